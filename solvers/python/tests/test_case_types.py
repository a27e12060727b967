"""Types of case files from their schema."""

import doctest
import json
import pathlib
import unittest

import case_types

SHIPPED = pathlib.Path(__file__).resolve().parents[3] / "docs" / "case.schema.json"

SCHEMA = {
    "type": "object",
    "required": ["name", "domain"],
    "properties": {
        "name": {"type": "string", "description": "Name of the case."},
        "domain": {"$ref": "#/$defs/domain"},
        "fluid": {"type": "object", "properties": {"lambda": {"type": "number"}, "scheme": {"enum": ["leapfrog"]}}},
        "wall": {"type": "array", "items": {"type": "object", "properties": {"shape": {"$ref": "#/$defs/shape"}}}},
    },
    "$defs": {
        "domain": {"type": "object", "properties": {"lower_m": {"type": "array", "items": {"type": "number"}}}},
        "shape": {
            "oneOf": [
                {"type": "object", "properties": {"type": {"const": "circle"}, "radius_m": {"type": "number"}}},
                {"type": "object", "properties": {"parts": {"type": "array", "items": {"$ref": "#/$defs/shape"}}}},
            ]
        },
    },
}


def load_tests(_loader, tests, _pattern):
    tests.addTests(doctest.DocTestSuite(case_types))
    return tests


class Generated(unittest.TestCase):
    def test_the_module_has_a_table_for_each_object(self):
        names = {}
        exec(case_types.generated(SCHEMA), names)
        case = names["CaseFile"]
        self.assertEqual(case.__required_keys__, {"name", "domain"})
        self.assertIn("lambda", names["CaseFileFluid"].__annotations__)
        # A shape of shapes.
        self.assertIn("Shape2", names)
        self.assertIn("Shape", str(names["Shape2"].__annotations__["parts"]))


    def test_the_module_of_the_package_is_that_of_the_schema(self):
        if not SHIPPED.is_file():
            self.skipTest(f"no {SHIPPED}")
        made = case_types.generated(json.loads(SHIPPED.read_text(encoding="utf-8")))
        command = "python3 solvers/python/case_types.py docs/case.schema.json"
        self.assertEqual(case_types.TARGET.read_text(encoding="utf-8"), made, f"make it again by {command}")


if __name__ == "__main__":
    unittest.main()
