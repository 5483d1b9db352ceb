import { Color, ShaderMaterial } from "three";

export const shadings = ["colour", "plain", "normals", "heat"] as const;
export type Shading = (typeof shadings)[number];

const vertexShader = /* glsl */ `
attribute vec3 positionFrom;
attribute vec4 tint;
uniform float morph;
varying vec3 eyePosition;
varying vec3 eyeNormal;
varying vec4 vertexTint;
void main() {
    vec4 eye = modelViewMatrix * vec4(mix(positionFrom, position, morph), 1.0);
    eyePosition = eye.xyz;
    eyeNormal = normalMatrix * normal;
    vertexTint = tint;
    gl_Position = projectionMatrix * eye;
}`;

// Colours are those of photographs, which have light and shade in them already, so they are lit but a little.
const fragmentShader = /* glsl */ `
uniform int shading;
uniform float coloured;
uniform vec3 clay;
varying vec3 eyePosition;
varying vec3 eyeNormal;
varying vec4 vertexTint;

vec3 ramp(float heat) {
    vec3 cold = vec3(0.16, 0.27, 0.60);
    vec3 warm = vec3(0.80, 0.25, 0.42);
    vec3 hot = vec3(1.00, 0.82, 0.35);
    return heat < 0.5 ? mix(cold, warm, 2.0 * heat) : mix(warm, hot, 2.0 * heat - 1.0);
}

void main() {
    vec3 n = normalize(eyeNormal);
    vec3 toEye = normalize(-eyePosition);
    float key = max(dot(n, normalize(vec3(-0.35, 0.55, 0.75))), 0.0);
    float sky = 0.5 + 0.5 * n.y;
    float rim = pow(1.0 - max(dot(n, toEye), 0.0), 3.0);
    float light = 0.30 + 0.28 * sky + 0.50 * key;
    vec3 colour;
    if (shading <= 1) {
        float gloss = pow(max(dot(reflect(-normalize(vec3(-0.35, 0.55, 0.75)), n), toEye), 0.0), 24.0);
        colour = clay * light + 0.10 * rim + 0.08 * gloss;
        if (shading == 0) colour = mix(colour, vertexTint.rgb * (0.84 + 0.22 * key), coloured);
    } else if (shading == 2) {
        colour = 0.5 + 0.5 * n;
    } else {
        float heat = vertexTint.a;
        colour = mix(clay * light, ramp(heat) * (0.65 + 0.4 * light), smoothstep(0.02, 0.12, heat));
    }
    gl_FragColor = vec4(colour, 1.0);
}`;

const edgeFragmentShader = /* glsl */ `
uniform vec3 ink;
void main() {
    gl_FragColor = vec4(ink, 0.34);
}`;

export interface Materials {
    readonly surface: ShaderMaterial;
    readonly edges: ShaderMaterial;
    setMorph(progress: number): void;
    /** How far the colours have come out of the plain surface, 0 to 1. */
    setColoured(progress: number): void;
    setShading(shading: Shading): void;
}

export function newMaterials(): Materials {
    const shared = { value: 1 }; // one uniform of both materials, so that edges stay on the surface
    const surface = new ShaderMaterial({
        vertexShader,
        fragmentShader,
        uniforms: { morph: shared, shading: { value: 0 }, coloured: { value: 0 }, clay: { value: new Color(0.82, 0.8, 0.76) } },
        polygonOffset: true,
        polygonOffsetFactor: 1,
        polygonOffsetUnits: 1,
    });
    const edges = new ShaderMaterial({
        vertexShader,
        fragmentShader: edgeFragmentShader,
        uniforms: { morph: shared, ink: { value: new Color(0.03, 0.03, 0.03) } },
        transparent: true,
        depthWrite: false,
    });
    return {
        surface,
        edges,
        setMorph: (progress) => (shared.value = progress),
        setColoured: (progress) => (surface.uniforms["coloured"].value = progress),
        setShading: (shading) => (surface.uniforms["shading"].value = shadings.indexOf(shading)),
    };
}
