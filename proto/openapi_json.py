"""Prints an OpenAPI document that is written in YAML as JSON, for /openapi.json. Needs Debian's python3-yaml.

  python3 proto/openapi_json.py proto/openapi.yaml
"""
import json
import sys

import yaml


class Loader(yaml.SafeLoader):
    """YAML 1.2's JSON schema, as OpenAPI wants it: no dates among the scalars."""


Loader.yaml_implicit_resolvers = {
    first: [(tag, pattern) for tag, pattern in resolvers if tag != "tag:yaml.org,2002:timestamp"]
    for first, resolvers in yaml.SafeLoader.yaml_implicit_resolvers.items()
}

with open(sys.argv[1], encoding="utf-8") as file:
    json.dump(yaml.load(file, Loader), sys.stdout, separators=(",", ":"))
