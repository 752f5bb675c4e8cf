// Completion scripts for three shells. Each completes commands, options, the known words of options, and otherwise files.
#include <fmt/format.h>
#include <fmt/ranges.h>

#include "runtime/base/assert.h"
#include "runtime/cli/command_line.h"
#include "runtime/cli/tables.h"

namespace meld::cli {
namespace {

std::string first_sentence(const std::string& text) {
    const std::string line = text.substr(0, text.find('\n'));
    return line.ends_with('.') ? line.substr(0, line.size() - 1) : line;
}

std::string replaced(std::string text, const std::string& from, const std::string& to) {
    for (std::size_t at = 0; (at = text.find(from, at)) != std::string::npos; at += to.size()) text.replace(at, from.size(), to);
    return text;
}

// The known words of an option or of a command's argument; empty if there are none.
std::vector<std::string> words_of(const Choices& choices, const std::string& name) {
    const auto found = choices.find(name);
    return found == choices.end() ? std::vector<std::string>{} : found->second;
}

std::vector<std::string> names_of(const OptionRow& option) {
    std::vector<std::string> names;
    for (const std::string& name : {option.short_name, option.long_name})
        if (!name.empty()) names.push_back(name);
    return names;
}

struct Script {
    std::string program;
    std::vector<CommandRow> commands;
    std::vector<OptionRow> options;
    const Choices& choices;

    std::string function() const { return "_" + replaced(program, "-", "_"); }
};

std::string all_names(const std::vector<OptionRow>& options) {
    std::vector<std::string> names;
    for (const OptionRow& option : options)
        for (const std::string& name : names_of(option)) names.push_back(name);
    return fmt::format("{}", fmt::join(names, " "));
}

std::string bash(const Script& s) {
    std::string by_value, by_command, commands;
    for (const CommandRow& command : s.commands) {
        commands += command.name + " ";
        for (const OptionRow& option : command.options) {
            const std::vector<std::string> words = words_of(s.choices, option.long_name);
            if (words.empty() && option.value != "DIR") continue;
            const std::string action = option.value == "DIR" ? "-d" : fmt::format("-W \"{}\"", fmt::join(words, " "));
            for (const std::string& name : names_of(option))
                by_value +=
                    fmt::format("        \"{} {}\") COMPREPLY=($(compgen {} -- \"$cur\")); return ;;\n", command.name, name, action);
        }
        const std::vector<std::string> words = words_of(s.choices, command.name);
        by_command +=
            fmt::format("        {}) options=\"{}\" words=\"{}\" ;;\n", command.name, all_names(command.options), fmt::join(words, " "));
    }
    return fmt::format(R"(# Completion of {0} for bash.
{1}() {{
    local cur=${{COMP_WORDS[COMP_CWORD]}} prev=${{COMP_WORDS[COMP_CWORD-1]}} options="{3}" words="{2}"
    COMPREPLY=()
    # Bash takes the = of --option=value for a word of its own.
    [ "$cur" = "=" ] && cur=""
    [ "$prev" = "=" ] && prev=${{COMP_WORDS[COMP_CWORD-2]}}
    case "${{COMP_WORDS[1]}} $prev" in
{4}    esac
    if [ "$COMP_CWORD" -gt 1 ]; then
        options="" words=""
        case "${{COMP_WORDS[1]}}" in
{5}        esac
    fi
    case "$cur" in
        -*) COMPREPLY=($(compgen -W "$options" -- "$cur")) ;;
        *) COMPREPLY=($(compgen -W "$words" -- "$cur")) ;;
    esac
}}
complete -o default -F {1} {0}
)",
                       s.program, s.function(), commands, all_names(s.options), by_value, by_command);
}

std::string zsh_text(const std::string& text) {
    std::string out = replaced(first_sentence(text), "'", "'\\''");
    for (const char* special : {"[", "]", ":"}) out = replaced(out, special, std::string("\\") + special);
    return out;
}

std::string zsh_options(const Script& s, const std::vector<OptionRow>& options) {
    std::string out;
    for (const OptionRow& option : options) {
        std::string action = " ";
        const std::vector<std::string> words = words_of(s.choices, option.long_name);
        if (!words.empty()) action = fmt::format("({})", fmt::join(words, " "));
        if (option.value == "FILE") action = "_files";
        if (option.value == "DIR") action = "_files -/";
        for (const std::string& name : names_of(option)) {
            const std::string joint = option.value.empty() ? "" : name.starts_with("--") ? "=" : "+";
            const std::string value = option.value.empty() ? "" : fmt::format(":{}:{}", option.value, action);
            out += fmt::format(" \\\n            '*{}{}[{}]{}'", name, joint, zsh_text(option.description), value);
        }
    }
    return out;
}

std::string zsh(const Script& s) {
    std::string commands, cases;
    for (const CommandRow& command : s.commands) {
        commands += fmt::format("        '{}:{}'\n", command.name, zsh_text(command.summary));
        const std::vector<std::string> words = words_of(s.choices, command.name);
        const std::string rest = words.empty() ? "_files" : fmt::format("({})", fmt::join(words, " "));
        cases += fmt::format("        {}) _arguments{} \\\n            '*:{}:{}' ;;\n", command.name, zsh_options(s, command.options),
                             command.arguments.empty() ? "argument" : zsh_text(command.arguments), rest);
    }
    if (s.commands.empty()) return fmt::format("#compdef {0}\n_arguments{1}\n", s.program, zsh_options(s, s.options));
    return fmt::format(R"(#compdef {0}
# Completion of {0} for zsh.
{1}() {{
    local -a commands
    commands=(
{2}    )
    if (( CURRENT == 2 )); then
        _describe -t commands command commands
        _arguments{3}
        return
    fi
    local command=$words[2]
    shift words
    (( CURRENT-- ))
    case $command in
{4}    esac
}}
if [ "$funcstack[1]" = {1} ]; then {1} "$@"; else compdef {1} {0}; fi
)",
                       s.program, s.function(), commands, zsh_options(s, s.options), cases);
}

std::string fish_line(const Script& s, const std::string& condition, const OptionRow& option) {
    std::string line = "complete -c " + s.program + condition;
    if (!option.short_name.empty()) line += " -s " + option.short_name.substr(1);
    if (!option.long_name.empty()) line += " -l " + option.long_name.substr(2);
    const std::vector<std::string> words = words_of(s.choices, option.long_name);
    if (!words.empty()) {
        line += fmt::format(" -x -a '{}'", fmt::join(words, " "));
    } else if (option.value == "FILE") {
        line += " -r -F";
    } else if (option.value == "DIR") {
        line += " -x -a '(__fish_complete_directories)'";
    } else if (!option.value.empty()) {
        line += " -x";
    }
    return line + " -d '" + replaced(first_sentence(option.description), "'", "\\'") + "'\n";
}

std::string fish(const Script& s) {
    std::string out = fmt::format("# Completion of {} for fish.\n", s.program);
    if (!s.commands.empty()) out += fmt::format("complete -c {} -n __fish_use_subcommand -f\n", s.program);
    for (const OptionRow& option : s.options) out += fish_line(s, s.commands.empty() ? "" : " -n __fish_use_subcommand", option);
    for (const CommandRow& command : s.commands) {
        const std::string summary = replaced(first_sentence(command.summary), "'", "\\'");
        out += fmt::format("complete -c {} -n __fish_use_subcommand -a {} -d '{}'\n", s.program, command.name, summary);
        const std::string condition = fmt::format(" -n '__fish_seen_subcommand_from {}'", command.name);
        const std::vector<std::string> words = words_of(s.choices, command.name);
        if (!words.empty()) out += fmt::format("complete -c {}{} -f -a '{}'\n", s.program, condition, fmt::join(words, " "));
        for (const OptionRow& option : command.options) out += fish_line(s, condition, option);
    }
    return out;
}

}  // namespace

std::string completion(const CLI::App& app, const std::string& shell, const Choices& choices) {
    MELD_EXPECT(shell == "bash" || shell == "zsh" || shell == "fish", "there is no completion for {}", shell);
    const Script script{app.get_name(), commands_of(app), options_of(app), choices};
    if (shell == "bash") return bash(script);
    return shell == "zsh" ? zsh(script) : fish(script);
}

}  // namespace meld::cli
