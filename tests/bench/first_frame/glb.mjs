// The usual way: one mesh as a GLB in Draco's compression, with the loaders of three.js, which starts its decoder first.
import { AmbientLight, PerspectiveCamera, Scene, WebGLRenderer } from "three";
import { DRACOLoader } from "three/addons/loaders/DRACOLoader.js";
import { GLTFLoader } from "three/addons/loaders/GLTFLoader.js";

const renderer = new WebGLRenderer({ antialias: true });
renderer.setSize(innerWidth, innerHeight);
document.body.append(renderer.domElement);
const scene = new Scene();
scene.add(new AmbientLight());
const camera = new PerspectiveCamera(32, innerWidth / innerHeight, 0.1, 1e6);
const draco = new DRACOLoader().setDecoderPath("/draco/").setWorkerLimit(1).preload();
const loader = new GLTFLoader().setDRACOLoader(draco);

document.getElementById("load").addEventListener("click", async () => {
    performance.mark("click");
    const { scene: model } = await loader.loadAsync(`/mesh.glb${location.search}`);
    const mesh = model.getObjectByProperty("isMesh", true);
    mesh.geometry.computeBoundingSphere();
    const { center, radius } = mesh.geometry.boundingSphere;
    camera.position.set(center.x, center.y, center.z + 4 * radius);
    scene.add(model);
    requestAnimationFrame(() => {
        renderer.render(scene, camera);
        performance.mark("drawn", { detail: mesh.geometry.attributes.position.count });
    });
});
document.body.dataset.ready = "1";
