"""What is uploaded has its verdict, file by file, before any job begins: a zip, a form, and files one by one."""

import base64
import hashlib
import json
import unittest

from harness import ServerTest, grey_png, run


def form_of(files, boundary="limit"):
    """A multipart/form-data body. @return (body, its Content-Type)"""
    body = b"".join(b'--%s\r\nContent-Disposition: form-data; name="file"; filename="%s"\r\n\r\n%s\r\n'
                    % (boundary.encode(), name.encode(), data) for name, data in files.items())
    return body + b"--%s--\r\n" % boundary.encode(), {"Content-Type": f"multipart/form-data; boundary={boundary}"}


class Captures(ServerTest):
    def files(self):
        return {str(f.relative_to(self.capture)): f.read_bytes() for f in sorted(self.capture.rglob("*"))
                if f.suffix in (".png", ".json") and f.name != "gt.ply"}

    def n_models(self):
        return len(json.loads(self.server.request("GET", "/v1/models")[2])["models"])

    def faults(self, body, headers=None):
        """What a refused upload is told, by path."""
        status, fields, answer = self.post(body=body, headers=headers)
        self.assertEqual((status, fields["Content-Type"]), (422, "application/problem+json"), answer)
        self.assertEqual(self.n_models(), 0)
        return {fault["path"]: fault["fault"] for fault in json.loads(answer)["faults"]}

    def test_the_answer_to_a_zip_lists_what_was_found_of_each_file(self):
        listed = json.loads(self.post("?vertices=500")[2])["files"]
        self.assertEqual([file["path"] for file in listed],
                         ["cameras.json"] + [f"{folder}/{i:03}.png" for folder in ("images", "masks") for i in range(12)])
        for file in listed:
            data = (self.capture / file["path"]).read_bytes()
            self.assertTrue(file["accepted"])
            self.assertEqual((file["bytes"], file["sha256"]), (len(data), hashlib.sha256(data).hexdigest()))
        self.assertEqual((listed[1]["kind"], listed[1]["width"], listed[1]["height"]), ("png", 160, 120))

    def test_a_zip_whose_images_cannot_be_used_is_refused_with_a_reason_for_each(self):
        image = (self.capture / "images/002.png").read_bytes()
        damaged = image[:len(image) // 2] + bytes([image[len(image) // 2] ^ 1]) + image[len(image) // 2 + 1:]
        faults = self.faults(self.changed_zip(images__000=b"no image", images__001=image[:700], images__002=damaged,
                                              images__003=grey_png(16, 12, 9), masks__004=grey_png(16, 12, 9), masks__005=None))
        self.assertEqual(sorted(faults), ["images/000.png", "images/001.png", "images/002.png", "images/003.png",
                                          "masks/003.png", "masks/004.png", "masks/005.png"])
        self.assertIn("160 x 120", faults["images/003.png"])
        self.assertIn("missing", faults["masks/005.png"])
        done = run("push", self.written(self.changed_zip(images__000=b"no image")), "--server", self.server.url, check=False)
        self.assertEqual(done.returncode, 3)
        self.assertIn("images/000.png: expected a PNG or JPEG", done.stderr)

    def written(self, data):
        file = self.folder / "written.zip"
        file.write_bytes(data)
        return file

    def test_a_form_is_looked_at_as_a_zip_is(self):
        body, headers = form_of(self.files())
        status, _, answer = self.post("?vertices=500", body, headers)
        self.assertEqual(status, 202, answer)
        self.assertEqual(len(json.loads(answer)["files"]), 25)
        self.server.request("DELETE", "/v1/models/" + json.loads(answer)["id"])
        body, headers = form_of({**self.files(), "images/001.png": b"no image"})
        self.assertEqual(list(self.faults(body, headers)), ["images/001.png"])
        body, headers = form_of({"capture.zip": self.changed_zip(images__001=b"no image")})
        self.assertEqual(list(self.faults(body, headers)), ["images/001.png"])

    def test_a_form_that_is_sent_again_with_its_key_makes_no_second_model(self):
        ids = set()
        for boundary in ("first", "another"):  # clients make one up each time
            body, headers = form_of(self.files(), boundary)
            status, _, answer = self.post("?vertices=500", body, {**headers, "Idempotency-Key": "a form of mine"})
            self.assertEqual(status, 202, answer)
            ids.add(json.loads(answer)["id"])
        self.assertEqual((len(ids), self.n_models()), (1, 1))
        body, headers = form_of({**self.files(), "images/001.png": self.files()["images/002.png"]})
        self.assertEqual(self.post("?vertices=500", body, {**headers, "Idempotency-Key": "a form of mine"})[0], 422)

    def test_files_that_come_one_by_one_have_their_verdict_at_once(self):
        place = "/v1/captures/" + json.loads(self.server.request("POST", "/v1/captures")[2])["id"]
        for name, data in self.files().items():
            digest = {"Content-Digest": f"sha-256=:{base64.b64encode(hashlib.sha256(data).digest()).decode()}:"}
            self.assertEqual(self.server.request("PUT", f"{place}/files/{name}", data, digest)[0], 201)
        status, _, answer = self.server.request("PUT", f"{place}/files/images/001.png", b"no image")
        self.assertEqual((status, json.loads(answer)["accepted"]), (200, False))
        status, _, answer = self.server.request("POST", "/v1/models?capture=" + place.rsplit("/", 1)[1])
        self.assertEqual(status, 422)
        self.assertEqual([fault["path"] for fault in json.loads(answer)["faults"]], ["images/001.png"])
        wrong = {"Content-Digest": f"sha-256=:{base64.b64encode(bytes(32)).decode()}:"}
        self.assertEqual(self.server.request("PUT", f"{place}/files/images/001.png", self.files()["images/001.png"], wrong)[0], 422)
        self.assertFalse(json.loads(self.server.request("GET", place)[2])["complete"])
        self.assertEqual(self.server.request("PUT", f"{place}/files/images/001.png", self.files()["images/001.png"])[0], 200)
        self.assertTrue(json.loads(self.server.request("GET", place)[2])["complete"])
        status, _, answer = self.server.request("POST", "/v1/models?vertices=500&capture=" + place.rsplit("/", 1)[1])
        self.assertEqual(status, 202)
        self.assertEqual(len(json.loads(answer)["files"]), 25)


if __name__ == "__main__":
    unittest.main()
