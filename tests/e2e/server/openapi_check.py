"""Whether an answer is one that the server's OpenAPI document promises: path, method, status, content type, JSON schema.

Knows the part of OpenAPI 3.1 and JSON Schema that proto/openapi.yaml uses, and refuses a keyword that it does not know, so
that no promise goes unchecked. Standard library only.
"""
import json
import re

ANNOTATIONS = {"description", "example", "default", "format", "title"}
TYPES = {"object": dict, "array": list, "string": str, "boolean": bool, "null": type(None)}
EVERYWHERE = {400, 401, 403, 404, 405, 408, 413, 414, 431, 500, 501, 503}  # problems that any request may meet


class Mismatch(AssertionError):
    """The answer is none that the document promises."""


class Document:
    def __init__(self, document):
        self.document = document
        self.paths = [(self.pattern_of(path), path) for path in document["paths"]]
        # Of two that match, the one with more fixed text is meant.
        self.paths.sort(key=lambda entry: -len(re.sub(r"\{[^}]*\}", "", entry[1])))

    @staticmethod
    def pattern_of(path):
        parts = re.split(r"(\{[^}]*\})", path)
        text = "".join((".+" if part == "{path}" else "[^/]+") if part.startswith("{") else re.escape(part) for part in parts)
        return re.compile(text + r"\Z")

    def resolve(self, node):
        while "$ref" in node:
            target = self.document
            for name in node["$ref"].removeprefix("#/").split("/"):
                target = target[name]
            node = target
        return node

    def operation(self, method, path):
        for pattern, template in self.paths:
            if pattern.match(path):
                operations = self.document["paths"][template]
                return template, operations.get("get" if method == "HEAD" else method.lower())
        return None, None

    def check(self, method, target, status, headers, body):
        """@raise Mismatch"""
        path = target.split("?")[0]
        template, operation = self.operation(method, path)
        where = f"{method} {template or path}: {status}"
        content_type = (headers.get("Content-Type") or "").split(";")[0]
        if "X-Request-Id" not in headers:
            raise Mismatch(f"{where}: no X-Request-Id")
        responses = operation["responses"] if operation else {}
        if str(status) in responses:
            promised = self.resolve(responses[str(status)])
        elif status in EVERYWHERE and content_type == "application/problem+json":
            promised = self.document["components"]["responses"]["Problem"]
        else:
            raise Mismatch(f"{where} is not promised")
        for name, header in promised.get("headers", {}).items():
            if name not in headers:
                raise Mismatch(f"{where}: no {name}")
            self.validate(headers[name], self.resolve(header["schema"]), f"{where}: {name}")
        content = promised.get("content")
        if content is None or method == "HEAD":
            if body:
                raise Mismatch(f"{where}: a body of {len(body)} bytes is not promised")
            return
        if content_type not in content:
            raise Mismatch(f"{where}: {content_type} is not promised, but {list(content)}")
        schema = content[content_type].get("schema")
        if schema is not None:
            self.validate(json.loads(body), schema, where)

    def validate(self, value, schema, where):
        """@raise Mismatch"""
        schema = self.resolve(schema)
        for keyword, rule in schema.items():
            check = getattr(self, "check_" + keyword.replace("$", ""), None)
            if check:
                check(value, rule, where, schema)
            elif keyword not in ANNOTATIONS:
                raise Mismatch(f"{where}: the keyword {keyword} is not known here")

    def check_type(self, value, rule, where, _):
        rules = rule if isinstance(rule, list) else [rule]
        for name in rules:
            if name in ("integer", "number"):
                fits = isinstance(value, (int, float) if name == "number" else int) and not isinstance(value, bool)
            else:
                fits = isinstance(value, TYPES[name])
            if fits:
                return
        raise Mismatch(f"{where}: {value!r} is no {rule}")

    def check_required(self, value, rule, where, _):
        if missing := [name for name in rule if name not in value]:
            raise Mismatch(f"{where}: {missing} are missing")

    def check_properties(self, value, rule, where, schema):
        for name, member in value.items():
            if name in rule:
                self.validate(member, rule[name], f"{where}.{name}")
            elif "additionalProperties" not in schema:
                raise Mismatch(f"{where}: the member {name} is not described")

    def check_additionalProperties(self, value, rule, where, schema):
        for name, member in value.items():
            if name not in schema.get("properties", {}):
                self.validate(member, rule, f"{where}.{name}")

    def check_items(self, value, rule, where, _):
        for i, item in enumerate(value):
            self.validate(item, rule, f"{where}[{i}]")

    def check_minItems(self, value, rule, where, _):
        if len(value) < rule:
            raise Mismatch(f"{where}: fewer than {rule} items")

    def check_maxItems(self, value, rule, where, _):
        if len(value) > rule:
            raise Mismatch(f"{where}: more than {rule} items")

    def check_enum(self, value, rule, where, _):
        if value not in rule:
            raise Mismatch(f"{where}: {value!r} is none of {rule}")

    def check_pattern(self, value, rule, where, _):
        if not re.search(rule, value):
            raise Mismatch(f"{where}: {value!r} does not match {rule}")

    def check_minimum(self, value, rule, where, _):
        if value < rule:
            raise Mismatch(f"{where}: {value} is below {rule}")

    def check_maximum(self, value, rule, where, _):
        if value > rule:
            raise Mismatch(f"{where}: {value} is above {rule}")

    def check_maxLength(self, value, rule, where, _):
        if len(value) > rule:
            raise Mismatch(f"{where}: longer than {rule}")
