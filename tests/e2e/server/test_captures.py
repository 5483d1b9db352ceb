"""A capture that arrives file by file, or as a form: what was sent stays, each image has its verdict, the model is the
same."""

import base64
import hashlib
import json
import unittest
import urllib.parse

from harness import ServerTest, run


def digest_field(body):
    return "sha-256=:" + base64.b64encode(hashlib.sha256(body).digest()).decode() + ":"


class Captures(ServerTest):
    def files(self):
        """The files of the capture, by path."""
        return {file.relative_to(self.capture).as_posix(): file.read_bytes() for file in sorted(self.capture.rglob("*"))
                if file.suffix in (".png", ".json")}

    def begin(self, key=None):
        status, headers, body = self.server.request("POST", "/v1/captures", headers={"Idempotency-Key": key} if key else {})
        self.assertEqual(status, 201, body)
        capture = json.loads(body)
        self.assertEqual(headers["Location"], "/v1/captures/" + capture["id"])
        return capture

    def put(self, capture_id, path, body, headers=None):
        status, _, answer = self.server.request("PUT", f"/v1/captures/{capture_id}/files/{urllib.parse.quote(path)}", body,
                                                headers or {"Content-Digest": digest_field(body)})
        return status, json.loads(answer)

    def show(self, capture_id):
        status, _, body = self.server.request("GET", "/v1/captures/" + capture_id)
        self.assertEqual(status, 200)
        return json.loads(body)

    def test_files_one_by_one_make_the_model_that_the_zip_makes(self):
        capture_id = self.begin()["id"]
        for path, body in self.files().items():
            status, file = self.put(capture_id, path, body)
            self.assertEqual((status, file["accepted"], file["bytes"]), (201, True, len(body)), file)
            self.assertEqual(file["sha256"], hashlib.sha256(body).hexdigest())
        self.assertTrue(self.show(capture_id)["complete"])
        status, _, body = self.server.request("POST", f"/v1/models?vertices=1000&coarse=800&capture={capture_id}")
        self.assertEqual(status, 202, body)
        model_id = json.loads(body)["id"]
        self.assertEqual(self.server.wait_until_final(model_id)["state"], "done")
        other_id = self.make_finished_model("?vertices=1000&coarse=800")
        for of_model in (model_id, other_id):
            run("fetch", self.url(of_model), "-o", self.folder / f"{of_model}.ply")
        self.assertEqual((self.folder / f"{model_id}.ply").read_bytes(), (self.folder / f"{other_id}.ply").read_bytes())
        self.assertEqual(self.server.request("DELETE", "/v1/captures/" + capture_id)[0], 204)
        self.assertEqual(self.server.request("GET", "/v1/captures/" + capture_id)[0], 404)
        self.assertFalse((self.server.data / "captures" / capture_id).exists())

    def test_captures_are_listed_page_by_page(self):
        begun = sorted(self.begin()["id"] for _ in range(5))
        self.put(begun[0], "images/a.png", b"no image")
        seen, target = [], "/v1/captures?limit=2"
        while target:
            status, _, body = self.server.request("GET", target)
            self.assertEqual(status, 200, body)
            page = json.loads(body)
            self.assertLessEqual(len(page["captures"]), 2)
            seen += page["captures"]
            target = page.get("next")
        mine = [capture for capture in seen if capture["id"] in begun]
        self.assertEqual([capture["id"] for capture in mine], begun)
        self.assertEqual((mine[0]["n_files"], mine[0]["bytes"], mine[1]["n_files"]), (1, 8, 0))
        self.assertEqual(self.server.request("GET", "/v1/captures?after=nobody")[0], 400)
        self.assertEqual(self.server.request("GET", "/v1/captures?limit=0")[0], 400)

    def test_an_upload_goes_on_where_it_stopped(self):
        files = self.files()
        first = self.begin("my scan")
        for path in list(files)[:5]:
            self.put(first["id"], path, files[path])
        self.server.kill()
        self.server = type(self.server)(self.server.data)
        again = self.begin("my scan")
        self.assertEqual(again["id"], first["id"])
        self.assertEqual([file["path"] for file in again["files"]], sorted(list(files)[:5]))
        self.assertFalse(again["complete"])
        status, _, body = self.server.request("POST", f"/v1/models?capture={first['id']}")
        self.assertEqual(status, 422)
        self.assertIn("missing", json.loads(body)["detail"])

    def test_bytes_with_another_digest_are_refused_and_leave_nothing(self):
        capture_id = self.begin()["id"]
        for field in ({"Content-Digest": digest_field(b"other")},
                      {"Digest": "SHA-256=" + base64.b64encode(hashlib.sha256(b"other").digest()).decode()}):
            self.assertEqual(self.put(capture_id, "images/000.png", b"one", field)[0], 422)
        self.assertEqual(self.put(capture_id, "images/000.png", b"one", {"Content-Digest": "sha-256=:x:"})[0], 400)
        self.assertEqual(self.show(capture_id)["files"], [])

    def test_each_image_has_its_verdict_before_the_job(self):
        capture_id = self.begin()["id"]
        files = self.files()
        files["images/000.png"] = b"GIF89a no photograph"
        for path, body in files.items():
            status, file = self.put(capture_id, path, body)
            self.assertEqual((status, file["accepted"]), (201, path != "images/000.png"), file)
        told = self.show(capture_id)
        self.assertEqual([fault["path"] for fault in told["faults"]], ["images/000.png"])
        self.assertEqual(self.server.request("POST", f"/v1/models?capture={capture_id}")[0], 422)
        status, _ = self.put(capture_id, "images/000.png", self.files()["images/000.png"])
        self.assertEqual(status, 200)  # replaced
        self.assertTrue(self.show(capture_id)["complete"])

    def test_paths_and_ids_that_lead_elsewhere_are_refused(self):
        capture_id = self.begin()["id"]
        for path in ("images/../../x.png", "../x.json", "images", "images/a/b.png", "x.png"):
            status, _, _ = self.server.request("PUT", f"/v1/captures/{capture_id}/files/{path}", b"x")
            self.assertIn(status, (400, 404), path)
        self.assertEqual(self.server.request("PUT", f"/v1/captures/{'a' * 26}/files/images/a.png", b"x")[0], 404)
        self.assertEqual(self.server.request("GET", "/v1/captures/..")[0], 404)
        self.assertEqual(self.show(capture_id)["files"], [])

    def form(self, parts):
        body = b"".join(b"--xyz\r\nContent-Disposition: form-data; name=\"%s\"; filename=\"%s\"\r\n\r\n%s\r\n"
                        % (name.encode(), filename.encode(), content) for name, filename, content in parts)
        return self.server.request("POST", "/v1/models?vertices=600&coarse=500", body + b"--xyz--\r\n",
                                   {"Content-Type": "multipart/form-data; boundary=xyz"})

    def test_forms_make_models(self):
        by_name = [(path.split("/")[0] if "/" in path else "cameras", path.split("/")[-1], body)
                   for path, body in self.files().items()]
        for parts in (by_name, [("capture", "capture.zip", self.zip.read_bytes())]):
            status, _, body = self.form(parts)
            self.assertEqual(status, 202, body)
            self.assertEqual(self.server.wait_until_final(json.loads(body)["id"])["state"], "done")
        self.assertEqual(self.form(by_name[:-1])[0], 422)
        self.assertEqual(self.form([])[0], 400)

    def test_push_sends_only_what_has_not_arrived(self):
        files = self.files()
        # What push asks for is named by the capture's contents, so a second push finds the first one's files.
        listing = "".join(f"{hashlib.sha256(body).hexdigest()} {path}\n" for path, body in sorted(files.items()))
        capture_id = self.begin(hashlib.sha256(listing.encode()).hexdigest())["id"]
        for path, body in list(files.items())[:-1]:
            self.put(capture_id, path, body)
        before = self.received()
        run("push", self.capture, "--server", self.server.url, "--wait", "--vertices", 600)
        self.assertEqual(self.received() - before, len(list(files.values())[-1]))

    def received(self):
        _, _, body = self.server.request("GET", "/metrics")
        return int(next(line for line in body.decode().splitlines() if line.startswith("anyrate_received_bytes_total ")).split()[1])

    def test_a_cancelled_model_ends_and_cannot_be_cancelled_twice(self):
        model_id = self.make_model("?vertices=100000&coarse=2500")
        self.server.wait_for(model_id, lambda model: model["state"] == "running")
        status, _, body = self.server.request("POST", f"/v1/models/{model_id}/cancel")
        self.assertEqual((status, json.loads(body)["state"]), (200, "cancelled"))
        self.assertEqual(self.server.request("POST", f"/v1/models/{model_id}/cancel")[0], 409)
        self.assertEqual(self.server.worker_pids(), [])


if __name__ == "__main__":
    unittest.main()
