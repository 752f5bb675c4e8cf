"""The manual pages of the programs as pages of the site: what `meldc help --man` prints from the table of its options."""
import re
import subprocess

PROGRAMS = ("meldc", "meldsim")


def plain(text):
    """A line without the escapes of roff, in which what is bold or in italics is code."""
    text = re.sub(r"\\f[BI](.*?)\\fR", lambda match: f"`{match[1]}`", text).replace("` `", " ")
    return re.sub(r"\\([-.&\\])", lambda match: "" if match[1] == "&" else match[1], text)


def escaped(text):
    """Plain text in Markdown: only code stays what it is."""
    return "`".join(part if at % 2 else re.sub(r"([\\*_<>\[\]|$~])", r"\\\1", part) for at, part in enumerate(text.split("`")))


def page(program, roff):
    out, lines, at = [f"# {program}(1)", ""], roff.splitlines(), 0
    while at < len(lines):
        request, _, rest = lines[at].partition(" ")
        at += 1
        if request == ".SH" and rest in ("NAME", "SYNOPSIS"):
            # The description says the first again, the headings below the second, one command after the other.
            while at < len(lines) and not lines[at].startswith(".SH"):
                at += 1
        elif request == ".SH" and rest == "DESCRIPTION":
            pass
        elif request == ".SH":
            out += ["", f"## {plain(rest).capitalize()}", ""]
        elif request == ".SS":
            out += ["", f"### {escaped(plain(rest))}", ""]
        elif request == ".nf":
            end = lines.index(".fi", at)
            out += ["", "```text", *(plain(line) for line in lines[at:end]), "```", ""]
            at = end + 1
        elif request == ".TP":
            out += ["", f"{plain(lines[at])}", f": {escaped(plain(lines[at + 1]))}"]
            at += 2
        elif request in (".PP", ".br", ".TH"):
            out.append("")
        elif request == ".B":
            out.append(f"`{plain(rest)}`")
        elif request.startswith("."):
            raise SystemExit(f"docs/site/commands.py: {program} help --man has a request that is not known here: {request}")
        else:
            out.append(escaped(plain(lines[at - 1])))
    return "\n".join(out) + "\n"


def pages(bin_folder):
    found = {}
    for program in PROGRAMS:
        roff = subprocess.run([bin_folder / program, "help", "--man"], capture_output=True, text=True, check=True).stdout
        found[f"manual/{program}"] = page(program, roff)
    found["manual/index"] = ("# Commands with all options\n\nThis page leads to the manual pages, which the programs print themselves "
                             "(`meldsim help --man`). [Commands](../commands.md) explains what they are for.\n\n"
                             "```{toctree}\n:maxdepth: 1\n\nmeldc\nmeldsim\n```\n")
    return found
