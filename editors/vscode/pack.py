#!/usr/bin/env python3
"""Packs this folder as an extension that VS Code installs, claymeld-VERSION.vsix, without vsce and without a network.

    pack.py [--from FOLDER, this one] [--out FILE]

What the extension needs of npm must be in node_modules: npm install --omit=dev. The same files give the same bytes.
"""
import argparse
import json
import pathlib
import sys
import xml.sax.saxutils
import zipfile

HERE = pathlib.Path(__file__).resolve().parent
# Not for those who use the extension.
LEFT_OUT = {"pack.py", "package-lock.json", ".package-lock.json", "__pycache__", ".bin"}
TYPES = {".json": "application/json", ".js": "application/javascript", ".md": "text/markdown", ".txt": "text/plain",
         ".vsixmanifest": "text/xml", ".yml": "text/yaml", ".sh": "application/x-sh"}
# Zip files begin here.
DATE = (1980, 1, 1, 0, 0, 0)


def manifest(package):
    def text(value):
        return xml.sax.saxutils.escape(value, {'"': "&quot;"})

    return f"""<?xml version="1.0" encoding="utf-8"?>
<PackageManifest Version="2.0.0" xmlns="http://schemas.microsoft.com/developer/vsx-schema/2011">
  <Metadata>
    <Identity Language="en-US" Id="{text(package["name"])}" Version="{text(package["version"])}" Publisher="{text(package["publisher"])}"/>
    <DisplayName>{text(package["displayName"])}</DisplayName>
    <Description xml:space="preserve">{text(package["description"])}</Description>
    <Categories>{text(",".join(package["categories"]))}</Categories>
    <Properties>
      <Property Id="Microsoft.VisualStudio.Code.Engine" Value="{text(package["engines"]["vscode"])}"/>
      <Property Id="Microsoft.VisualStudio.Code.ExtensionKind" Value="workspace"/>
      <Property Id="Microsoft.VisualStudio.Code.ExecutesCode" Value="true"/>
      <Property Id="Microsoft.VisualStudio.Services.GitHubFlavoredMarkdown" Value="true"/>
    </Properties>
  </Metadata>
  <Installation><InstallationTarget Id="Microsoft.VisualStudio.Code"/></Installation>
  <Dependencies/>
  <Assets>
    <Asset Type="Microsoft.VisualStudio.Code.Manifest" Path="extension/package.json" Addressable="true"/>
    <Asset Type="Microsoft.VisualStudio.Services.Content.Details" Path="extension/README.md" Addressable="true"/>
  </Assets>
</PackageManifest>
"""


def content_types(names):
    """Every file of a package has the type of its ending, or else one of its own."""
    endings = sorted({pathlib.PurePosixPath(name).suffix for name in names} - {""})
    lines = [f'<Default Extension="{ending}" ContentType="{TYPES.get(ending, "application/octet-stream")}"/>' for ending in endings]
    lines += [f'<Override PartName={xml.sax.saxutils.quoteattr("/" + name)} ContentType="application/octet-stream"/>'
              for name in sorted(names) if not pathlib.PurePosixPath(name).suffix]
    return ('<?xml version="1.0" encoding="utf-8"?>\n<Types xmlns="http://schemas.openxmlformats.org/package/2006/content-types">\n'
            + "\n".join(lines) + "\n</Types>\n")


def pack(folder, out):
    package = json.loads((folder / "package.json").read_text())
    for name in package["dependencies"]:
        if not (folder / "node_modules" / name).is_dir():
            sys.exit(f"pack.py: the extension needs {name}, which is not in {folder / 'node_modules'}. "
                     f"Run there: npm install --omit=dev")
    files = {f"extension/{path.relative_to(folder).as_posix()}": path.read_bytes() for path in sorted(folder.rglob("*"))
             if path.is_file() and path.suffix != ".vsix" and not LEFT_OUT & set(path.relative_to(folder).parts)}
    files = {"extension.vsixmanifest": manifest(package).encode(), **files}
    out = out or folder / f"{package['name']}-{package['version']}.vsix"
    with zipfile.ZipFile(out, "w", zipfile.ZIP_DEFLATED) as archive:
        for name, content in {"[Content_Types].xml": content_types(files).encode(), **files}.items():
            entry = zipfile.ZipInfo(name, DATE)
            entry.compress_type, entry.external_attr = zipfile.ZIP_DEFLATED, 0o644 << 16
            archive.writestr(entry, content)
    return out, len(files)


def main():
    arguments = argparse.ArgumentParser()
    arguments.add_argument("--from", dest="folder", type=pathlib.Path, default=HERE)
    arguments.add_argument("--out", type=pathlib.Path)
    options = arguments.parse_args()
    out, count = pack(options.folder.resolve(), options.out)
    print(f"{out}: {count} files")


if __name__ == "__main__":
    main()
