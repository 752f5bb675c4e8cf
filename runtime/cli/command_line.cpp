#include "runtime/cli/command_line.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <filesystem>
#include <iostream>
#include <string_view>

#include "runtime/base/did_you_mean.h"
#include "runtime/base/error.h"
#include "runtime/base/terminal/terminal_text.h"
#include "runtime/base/version.h"
#include "runtime/cli/tables.h"
#include "runtime/cli/usage_error.h"

namespace meld::cli {
namespace {

const std::vector<std::string_view> kShells = {"bash", "zsh", "fish"};

const CLI::App* command_named(const CLI::App& app, const std::string& name) {
    const std::vector<const CLI::App*> found = app.get_subcommands([&name](const CLI::App* each) { return each->get_name() == name; });
    return found.empty() ? nullptr : found[0];
}

int print(const std::string& text) {
    std::cout << text;
    return 0;
}

// `help`, `help COMMAND` and `help --man`.
int help(const CLI::App& app, const std::string& name, bool manual, const Elsewhere& elsewhere) {
    if (manual) return print(manual_page(app));
    if (name.empty()) return print(app.get_formatter()->make_help(&app, app.get_name(), CLI::AppFormatMode::Normal));
    const CLI::App* command = command_named(app, name);
    return command == nullptr ? no_such_command(app, name, elsewhere) : print(command->help(app.get_name()));
}

// The command in `meldsim run help`, unless there is a file of that name.
const CLI::App* asked_for_help(const CLI::App& app, int argc, const char* const* argv) {
    std::error_code error;
    if (argc != 3 || std::string_view(argv[2]) != "help" || std::filesystem::exists("help", error)) return nullptr;
    const CLI::App* command = command_named(app, argv[1]);
    return command == nullptr || command->get_name() == "help" ? nullptr : command;
}

// `--json=no` would be read as a flag with a value, which no flag here has.
void refuse_values_of_flags(CLI::App& command) {
    for (CLI::Option* option : command.get_options())
        if (option->get_items_expected_max() == 0) option->disable_flag_override();
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
    for (CLI::App* command : app.get_subcommands([](const CLI::App*) { return true; })) refuse_values_of_flags(*command);
}

CLI::Validator whole_number(std::int64_t least, std::int64_t greatest) {
    const auto check = [least, greatest](const std::string& text) {
        std::int64_t number = 0;
        const char* const last = text.data() + text.size();
        const auto [end, error] = std::from_chars(text.data(), last, number);
        if (error == std::errc() && end == last && least <= number && number <= greatest) return std::string();
        return fmt::format("takes a whole number from {} to {}, not '{}'", least, greatest, text);
    };
    return {check, ""};
}

CLI::Validator seconds() {
    const auto check = [](const std::string& text) {
        double number = 0;
        const char* const last = text.data() + text.size();
        const auto [end, error] = std::from_chars(text.data(), last, number);
        // Not a number is neither less nor more.
        if (error == std::errc() && end == last && 0.001 <= number && number <= 1e9) return std::string();
        return fmt::format("takes seconds from 0.001 to 1e9, not '{}'", text);
    };
    return {check, ""};
}

std::optional<int> parse(CLI::App& app, int argc, const char* const* argv, const Choices& choices, const Elsewhere& elsewhere) {
    if (const CLI::App* command = asked_for_help(app, argc, argv)) return print(command->help(app.get_name()));
    try {
        app.parse(argc, argv);
    } catch (const CLI::Success& success) {
        return app.exit(success);
    } catch (const CLI::ParseError& error) {
        return report_usage(app, error, argc, argv, elsewhere);
    }
    const CLI::App* help_command = command_named(app, "help");
    if (help_command != nullptr && help_command->parsed()) {
        const CLI::Option* name = help_command->get_option("COMMAND");
        return help(app, name->count() == 0 ? "" : name->results()[0], help_command->get_option("--man")->count() > 0, elsewhere);
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
