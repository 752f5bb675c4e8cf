#include "runtime/cli/command_line.h"

#include <fmt/format.h>

#include <algorithm>
#include <iostream>

#include "runtime/base/error.h"
#include "runtime/base/nearest.h"
#include "runtime/base/version.h"
#include "runtime/cli/tables.h"

namespace meld::cli {
namespace {

const std::vector<std::string_view> kShells = {"bash", "zsh", "fish"};

int usage_error(const std::string& where, const Error& error) {
    std::cerr << where << ": " << error.message() << "\n";
    return static_cast<int>(ExitCode::UsageOrWorld);
}

const CLI::App* command_named(const CLI::App& app, const std::string& name) {
    const std::vector<const CLI::App*> found = app.get_subcommands([&name](const CLI::App* each) { return each->get_name() == name; });
    return found.empty() ? nullptr : found[0];
}

std::vector<std::string> command_names(const CLI::App& app) {
    std::vector<std::string> names;
    for (const CommandRow& command : commands_of(app)) names.push_back(command.name);
    return names;
}

std::string nearest_of(const std::string& word, const std::vector<std::string>& known) {
    const std::vector<std::string_view> views(known.begin(), known.end());
    return did_you_mean(word, views);
}

int no_such_command(const CLI::App& app, const std::string& name) {
    return usage_error(app.get_name(), {fmt::format("there is no command '{}'", name), nearest_of(name, command_names(app))});
}

// Names the nearest option where there is one; the list of all would be long.
int no_such_option(const CLI::App& command, const std::string& where, const std::string& argument) {
    const std::string option = argument.substr(0, argument.find('='));
    std::vector<std::string> known;
    for (const OptionRow& row : options_of(command))
        for (const std::string& name : {row.short_name, row.long_name})
            if (!name.empty()) known.push_back(name);
    const std::vector<std::string_view> views(known.begin(), known.end());
    const std::optional<std::string_view> near = nearest_name(option, views);
    const std::string cure = near ? fmt::format("did you mean '{}'?", *near) : fmt::format("'{} --help' lists the options", where);
    return usage_error(where, {fmt::format("there is no option '{}'", option), cure});
}

int print(const std::string& text) {
    std::cout << text << std::flush;
    return std::cout ? 0 : static_cast<int>(ExitCode::UsageOrWorld);
}

// `help`, `help COMMAND` and `help --man`.
int help(const CLI::App& app, const std::string& name, bool manual) {
    if (manual) return print(manual_page(app));
    if (name.empty()) return print(app.get_formatter()->make_help(&app, app.get_name(), CLI::AppFormatMode::Normal));
    const CLI::App* command = command_named(app, name);
    return command == nullptr ? no_such_command(app, name) : print(command->help(app.get_name()));
}

int report(const CLI::App& app, const CLI::ParseError& error, int argc, const char* const* argv) {
    const std::vector<CLI::App*> chosen = const_cast<CLI::App&>(app).get_subcommands();
    if (chosen.empty() && !app.get_subcommands([](const CLI::App*) { return true; }).empty()) {
        if (argc > 1 && argv[1][0] != '-') return no_such_command(app, argv[1]);
        if (argc == 1) return usage_error(app.get_name(), {"a command is needed", fmt::format("'{} help' lists them", app.get_name())});
    }
    const CLI::App& command = chosen.empty() ? app : *chosen.back();
    const std::string where = app.get_name() + (chosen.empty() ? "" : " " + command.get_name());
    const std::vector<std::string> unknown = app.remaining(true);
    const auto option =
        std::find_if(unknown.begin(), unknown.end(), [](const std::string& word) { return word.size() > 1 && word[0] == '-'; });
    if (option != unknown.end()) return no_such_option(command, where, *option);
    if (!unknown.empty() && dynamic_cast<const CLI::ExtrasError*>(&error) != nullptr)
        return usage_error(where, {fmt::format("'{}' is one argument too many", unknown[0]), fmt::format("see '{} --help'", where)});
    return usage_error(where, {error.what(), fmt::format("see '{} --help'", where)});
}

}  // namespace

void add_common(CLI::App& app) {
    app.set_version_flag("--version", fmt::format("{} {}", app.get_name(), kVersion));
    const bool has_commands = !app.get_subcommands([](const CLI::App*) { return true; }).empty();
    if (!has_commands) return;
    CLI::App* help =
        app.add_subcommand("help", fmt::format("Explain a command.\nExample: {0} help {1}", app.get_name(), command_names(app)[0]));
    help->add_option("COMMAND", "The command; without it, all commands are listed");
    help->add_flag_callback("--man", [] {}, "Print the manual page, in roff");
    CLI::App* completion = app.add_subcommand(
        "completion", fmt::format("Print the completion script of a shell.\nExample: {0} completion bash > ~/.local/share/bash-completion/"
                                  "completions/{0}",
                                  app.get_name()));
    completion->add_option("SHELL", "bash, zsh or fish")->required();
}

std::optional<int> parse(CLI::App& app, int argc, const char* const* argv, const Choices& choices) {
    try {
        app.parse(argc, argv);
    } catch (const CLI::Success& success) {
        return app.exit(success);
    } catch (const CLI::ParseError& error) {
        return report(app, error, argc, argv);
    }
    const CLI::App* help_command = command_named(app, "help");
    if (help_command != nullptr && help_command->parsed()) {
        const CLI::Option* name = help_command->get_option("COMMAND");
        return help(app, name->count() == 0 ? "" : name->results()[0], help_command->get_option("--man")->count() > 0);
    }
    const CLI::App* completion_command = command_named(app, "completion");
    if (completion_command != nullptr && completion_command->parsed()) {
        const std::string shell = completion_command->get_option("SHELL")->results()[0];
        if (std::find(kShells.begin(), kShells.end(), shell) == kShells.end())
            return usage_error(app.get_name() + " completion",
                               {fmt::format("there is no completion for '{}'", shell), did_you_mean(shell, kShells)});
        Choices all = choices;
        all["help"] = command_names(app);
        all["completion"] = {kShells.begin(), kShells.end()};
        return print(completion(app, shell, all));
    }
    return std::nullopt;
}

}  // namespace meld::cli
