"""The extension of VS Code as one file: everything that its manifest names is in it, with a type.

    vsix_test.py [unittest options]
"""
import json
import pathlib
import re
import shutil
import subprocess
import sys
import xml.etree.ElementTree
import zipfile

ROOT = pathlib.Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT / "tests"))

from frame import Case, main  # noqa: E402

SOURCE = ROOT / "editors" / "vscode"
TYPES = "{http://schemas.openxmlformats.org/package/2006/content-types}"
SCHEMA = "{http://schemas.microsoft.com/developer/vsx-schema/2011}"


class Packed(Case):
    def setUp(self):
        super().setUp()
        self.source = self.folder / "vscode"
        shutil.copytree(SOURCE, self.source, ignore=shutil.ignore_patterns("node_modules", "*.vsix"))
        self.package = json.loads((self.source / "package.json").read_text())

    def add_dependencies(self):
        """In the place of what npm brings."""
        for name in self.package["dependencies"]:
            self.write(f"vscode/node_modules/{name}/package.json", json.dumps({"name": name, "main": "main.js"}))
            self.write(f"vscode/node_modules/{name}/main.js", "exports.LanguageClient = class {};\n")
            self.write(f"vscode/node_modules/{name}/LICENSE", "free\n")
            self.write("vscode/node_modules/.bin/tool", "left out\n")

    def pack(self):
        return subprocess.run(["/usr/bin/python3", "-B", self.source / "pack.py"], capture_output=True, text=True)

    def packed(self):
        done = self.pack()
        self.assertEqual(done.returncode, 0, done.stderr)
        path = self.source / f"claymeld-{self.package['version']}.vsix"
        self.assertIn(str(path), done.stdout)
        return path

    def named_files(self, value):
        """The files that the manifest names: strings that begin with ./"""
        if isinstance(value, dict):
            value = list(value.values())
        if isinstance(value, list):
            return [name for part in value for name in self.named_files(part)]
        return [value.removeprefix("./")] if isinstance(value, str) and value.startswith("./") else []

    def test_everything_that_is_named_is_in_it(self):
        self.add_dependencies()
        with zipfile.ZipFile(self.packed()) as archive:
            self.assertIsNone(archive.testzip())
            names = archive.namelist()
            self.assertEqual(names[0], "[Content_Types].xml")
            self.assertEqual(json.loads(archive.read("extension/package.json")), self.package)
            files = self.named_files(self.package)
            self.assertIn("client.js", files)
            for name in [*files, "debug.js", "costs.js", "node_modules/vscode-languageclient/main.js", "README.md"]:
                self.assertEqual(archive.read(f"extension/{name}"), (self.source / name).read_bytes(), name)
            for name in ("pack.py", ".bin", ".vsix", "package-lock"):
                self.assertFalse([found for found in names if name in found.removeprefix("extension.vsixmanifest")], name)
            # What the scripts load is there, or comes with the editor or with Node.
            for script in ("client.js", "debug.js", "costs.js"):
                for module in re.findall(r'require\("([^"]+)"\)', archive.read(f"extension/{script}").decode()):
                    local = f"extension/{module.removeprefix('./')}"
                    self.assertTrue(module in ("vscode", "path", "fs", "child_process") or f"{local}.js" in names or local in names
                                    or f"extension/node_modules/{module.split('/')[0]}/package.json" in names, module)
            types = xml.etree.ElementTree.fromstring(archive.read("[Content_Types].xml"))
            endings = {part.attrib["Extension"] for part in types.iter(f"{TYPES}Default")}
            alone = {part.attrib["PartName"] for part in types.iter(f"{TYPES}Override")}
            for name in names[1:]:
                self.assertTrue(pathlib.PurePosixPath(name).suffix in endings or f"/{name}" in alone, name)
            manifest = xml.etree.ElementTree.fromstring(archive.read("extension.vsixmanifest"))
            identity = next(manifest.iter(f"{SCHEMA}Identity")).attrib
            self.assertEqual((identity["Id"], identity["Version"], identity["Publisher"]),
                             tuple(self.package[key] for key in ("name", "version", "publisher")))
            for asset in manifest.iter(f"{SCHEMA}Asset"):
                self.assertIn(asset.attrib["Path"], names)

    def test_the_same_files_give_the_same_bytes(self):
        self.add_dependencies()
        path = self.packed()
        first = path.read_bytes()
        self.assertEqual(self.packed().read_bytes(), first)

    def test_what_npm_must_bring_is_said(self):
        done = self.pack()
        self.assertEqual(done.returncode, 1)
        self.assertIn("vscode-languageclient, which is not in", done.stderr)
        self.assertIn("npm install", done.stderr)
        self.assertFalse(list(self.source.glob("*.vsix")))

    def test_it_has_the_version_of_claymeld(self):
        version = re.search(r'kVersion\[\] = "(.*?)"', (ROOT / "runtime/base/version.h").read_text())[1]
        self.assertEqual(self.package["version"], version)


if __name__ == "__main__":
    main()
