#include "runtime/debug/command.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <vector>

#include "runtime/base/nearest.h"

namespace meld::debug {

namespace {

using Words = std::vector<std::string_view>;

// How a command is written, what it does, and how the words after its name are read.
struct Entry {
    std::string_view name, arguments, help;
    std::size_t most_words;
    Result<Command> (*read)(const Entry& entry, const Words& words);
};

tl::unexpected<Error> wrong(const Entry& entry, std::string problem) {
    return fail(fmt::format("{}: {}", entry.name, problem),
                fmt::format("Write {}{}{}", entry.name, entry.arguments.empty() ? "" : " ", entry.arguments));
}

template <class Number>
Result<Number> number(const Entry& entry, std::string_view word, Number least) {
    Number value{};
    const auto [end, error] = std::from_chars(word.data(), word.data() + word.size(), value);
    if (error == std::errc::result_out_of_range) return wrong(entry, fmt::format("{} is too large", word));
    if (error != std::errc{} || end != word.data() + word.size() || value < least)
        return wrong(entry, fmt::format("'{}' is no whole number from {} on", word, least));
    return value;
}

template <class Moves>
Result<Command> read_ticks(const Entry& entry, const Words& words) {
    if (words.empty()) return Moves{};
    return number<std::int64_t>(entry, words[0], 1).map([](std::int64_t n) -> Command { return Moves{n}; });
}

Result<Command> read_to(const Entry& entry, const Words& words) {
    if (words.empty()) return wrong(entry, "the tick is missing");
    return number<std::int64_t>(entry, words[0], 0).map([](std::int64_t tick) -> Command { return To{tick}; });
}

Result<Command> read_facts(const Entry& entry, const Words& words) {
    Facts facts;
    for (const std::string_view word : words) {
        if (word.front() != '@') {
            if (!facts.name.empty()) return wrong(entry, fmt::format("'{}' is a second name", word));
            facts.name = word;
            continue;
        }
        if (facts.catom) return wrong(entry, fmt::format("{} is a second catom", word));
        const Result<std::uint64_t> id = number<std::uint64_t>(entry, word.substr(1), 0);
        if (!id) return tl::unexpected<Error>(id.error());
        facts.catom = *id;
    }
    return facts;
}

Result<Command> read_diff(const Entry& entry, const Words& words) {
    if (words.empty()) return Diff{};
    return number<std::int64_t>(entry, words[0], 0).map([](std::int64_t tick) -> Command { return Diff{tick}; });
}

template <class Alone>
Result<Command> read_alone(const Entry&, const Words&) {
    return Alone{};
}

Result<Command> read_help(const Entry&, const Words& words);

constexpr std::array<Entry, 10> kCommands = {{
    {"step", "[N]", "go N ticks forward, or one; Enter alone does the same at the prompt", 1, read_ticks<Step>},
    {"back", "[N]", "go N ticks back, or one", 1, read_ticks<Back>},
    {"to", "T", "go to the end of tick T, forward or back; 0 is the state before the first tick", 1, read_to},
    {"run", "", "go on until nothing is left to do, or to the limits of the run", 0, read_alone<Run>},
    {"facts", "[@N] [NAME]", "what holds now: everything, what holds at catom N, or the facts of one predicate", 2, read_facts},
    {"where", "", "the tick, the number of catoms, the digest, and how far back snapshots reach", 0, read_alone<Where>},
    {"catoms", "", "the same as where", 0, read_alone<Where>},
    {"diff", "[T]", "how many facts have come and gone since tick T, or since before the last step, back, to or run", 1, read_diff},
    {"help", "[COMMAND]", "what can be typed", 1, read_help},
    {"quit", "", "end the session, as the end of the input does", 0, read_alone<Quit>},
}};

constexpr auto kNames = [] {
    std::array<std::string_view, kCommands.size()> names;
    std::transform(kCommands.begin(), kCommands.end(), names.begin(), [](const Entry& entry) { return entry.name; });
    return names;
}();

Result<const Entry*> find(std::string_view name) {
    const auto found = std::ranges::find(kCommands, name, &Entry::name);
    if (found != kCommands.end()) return &*found;
    if (const auto near = nearest_name(name, kNames))
        return fail(fmt::format("there is no command '{}'", name), fmt::format("Did you mean '{}'?", *near));
    return fail(fmt::format("there is no command '{}'", name), fmt::format("There are {}", fmt::join(kNames, ", ")));
}

std::string line_of(const Entry& entry) { return fmt::format("{:<6} {:<12} {}\n", entry.name, entry.arguments, entry.help); }

Result<Command> read_help(const Entry&, const Words& words) {
    std::string text;
    if (!words.empty()) return find(words[0]).map([](const Entry* entry) -> Command { return Help{line_of(*entry)}; });
    for (const Entry& entry : kCommands) text += line_of(entry);
    return Help{std::move(text)};
}

Words split(std::string_view line) {
    constexpr std::string_view kBlanks = " \t\r";
    Words words;
    for (std::size_t begin = 0; (begin = line.find_first_not_of(kBlanks, begin)) != std::string_view::npos;) {
        const std::size_t end = std::min(line.find_first_of(kBlanks, begin), line.size());
        words.push_back(line.substr(begin, end - begin));
        begin = end;
    }
    return words;
}

}  // namespace

Result<Command> parse_command(std::string_view line) {
    Words words = split(line);
    const Result<const Entry*> entry = find(words.empty() ? "" : words[0]);
    if (!entry) return tl::unexpected<Error>(entry.error());
    words.erase(words.begin());
    if (words.size() > (*entry)->most_words) return wrong(**entry, fmt::format("'{}' is too much", words[(*entry)->most_words]));
    return (*entry)->read(**entry, words);
}

}  // namespace meld::debug
