# SPDX-License-Identifier: MIT
# Validates a T4 document by the schemas that Kernel Tuner brings along: pip install kernel-tuner.
#
#   t4.py DOCUMENT    ends with 77 where Kernel Tuner is not installed
import importlib.util
import json
import pathlib
import sys

kernel_tuner = importlib.util.find_spec("kernel_tuner")
if not kernel_tuner or not importlib.util.find_spec("jsonschema"):
    sys.exit(77)
import jsonschema

document = json.loads(pathlib.Path(sys.argv[1]).read_text(encoding="utf-8"))
folder = pathlib.Path(kernel_tuner.origin).parent / "schema/T4" / document["schema_version"]
for name in ("results", "metadata"):
    schema = json.loads((folder / f"{name}-schema.json").read_text(encoding="utf-8"))
    jsonschema.Draft202012Validator(schema).validate(document)
