// A manual page in roff, section 1.
#include <fmt/format.h>

#include "runtime/base/version.h"
#include "runtime/cli/command_line.h"
#include "runtime/cli/tables.h"

namespace meld::cli {
namespace {

// Text that roff prints unchanged.
std::string plain(const std::string& text) {
    std::string out;
    for (const char c : text) {
        if (c == '\\') {
            out += "\\e";
        } else if (c == '-') {
            out += "\\-";
        } else {
            if ((c == '.' || c == '\'') && (out.empty() || out.back() == '\n')) out += "\\&";
            out += c;
        }
    }
    return out;
}

std::string upper(std::string text) {
    for (char& c : text) c = static_cast<char>(std::toupper(static_cast<unsigned char>(c)));
    return text;
}

std::string option_entries(const std::vector<OptionRow>& options) {
    std::string out;
    for (const OptionRow& option : options) {
        std::string names;
        for (const std::string& name : {option.short_name, option.long_name})
            if (!name.empty()) names += (names.empty() ? "\\fB" : ", \\fB") + plain(name) + "\\fR";
        if (!option.value.empty()) names += " \\fI" + plain(option.value) + "\\fR";
        out += fmt::format(".TP\n{}\n{}\n", names, plain(option.description));
    }
    return out;
}

std::string command_entry(const std::string& program, const CommandRow& command) {
    std::string out =
        fmt::format(".SS {} {} {}\n{}\n", plain(program), plain(command.name), plain(command.arguments), plain(command.summary));
    if (!command.example.empty()) out += fmt::format(".PP\n.nf\n{}\n.fi\n", plain(command.example));
    return out + option_entries(command.options);
}

}  // namespace

std::string manual_page(const CLI::App& app) {
    const std::string name = app.get_name();
    // A description opens with "NAME does this.", then perhaps an example.
    const std::string description = app.get_description().substr(0, app.get_description().find('\n'));
    std::string summary = description.starts_with(name + " ") ? description.substr(name.size() + 1) : description;
    if (summary.ends_with('.')) summary.pop_back();
    const std::vector<CommandRow> commands = commands_of(app);
    std::string out = fmt::format(".TH {} 1 \"\" \"Claymeld {}\" \"User Commands\"\n", upper(plain(name)), kVersion);
    out += fmt::format(".SH NAME\n{} \\- {}\n", plain(name), plain(summary));
    out += ".SH SYNOPSIS\n";
    for (const CommandRow& command : commands)
        out += fmt::format(".B {} {}\n[options] {}\n.br\n", plain(name), plain(command.name), plain(command.arguments));
    if (commands.empty()) out += fmt::format(".B {}\n[options]\n", plain(name));
    out += fmt::format(".SH DESCRIPTION\n{}\n", plain(description));
    if (!commands.empty()) out += ".SH COMMANDS\n";
    for (const CommandRow& command : commands) out += command_entry(name, command);
    out += ".SH OPTIONS\n" + option_entries(options_of(app));
    if (!app.get_footer().empty()) out += fmt::format(".SH EXIT STATUS\n{}\n", plain(app.get_footer()));
    out += ".SH SEE ALSO\n";
    std::string others;
    for (const char* other : {"meldc", "meldsim"})
        if (name != other) others += fmt::format("{}\\fB{}\\fR(1)", others.empty() ? "" : ",\n", plain(other));
    return out + others + "\n";
}

}  // namespace meld::cli
