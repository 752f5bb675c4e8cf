#include "runtime/cli/tables.h"

#include <CLI/CLI.hpp>

#include "runtime/base/assert.h"

namespace meld::cli {
namespace {

// The text after "Example: " in a description, and the text before it.
std::pair<std::string, std::string> split_example(const std::string& description) {
    const std::string mark = "\nExample: ";
    const std::size_t at = description.find(mark);
    if (at == std::string::npos) return {description, ""};
    return {description.substr(0, at), description.substr(at + mark.size())};
}

}  // namespace

std::vector<OptionRow> options_of(const CLI::App& app) {
    std::vector<OptionRow> rows;
    for (const CLI::Option* option : app.get_options()) {
        if (option->get_positional() || option->get_group().empty()) continue;
        OptionRow row;
        if (!option->get_snames().empty()) row.short_name = "-" + option->get_snames()[0];
        if (!option->get_lnames().empty()) row.long_name = "--" + option->get_lnames()[0];
        if (option->get_items_expected_max() > 0) row.value = option->get_type_name().empty() ? "VALUE" : option->get_type_name();
        // A check of a range appends its limits to the type.
        row.value = row.value.substr(0, row.value.find(':'));
        row.description = option->get_description();
        rows.push_back(std::move(row));
    }
    return rows;
}

std::vector<CommandRow> commands_of(const CLI::App& app) {
    std::vector<CommandRow> rows;
    for (const CLI::App* command : app.get_subcommands([](const CLI::App* each) { return !each->get_group().empty(); })) {
        CommandRow row;
        row.name = command->get_name();
        std::tie(row.summary, row.example) = split_example(command->get_description());
        for (const CLI::Option* option : command->get_options()) {
            if (!option->get_positional()) continue;
            const std::string many = option->get_items_expected_max() > 1 ? "..." : "";
            const std::string word = option->get_name() + many;
            row.arguments += (row.arguments.empty() ? "" : " ") + (option->get_required() ? word : "[" + word + "]");
        }
        row.options = options_of(*command);
        rows.push_back(std::move(row));
    }
    return rows;
}

}  // namespace meld::cli
