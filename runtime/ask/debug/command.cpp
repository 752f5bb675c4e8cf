#include "runtime/ask/debug/command.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <limits>
#include <vector>

#include "runtime/base/did_you_mean.h"

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

// The words as they were typed, with the blanks between them.
std::string_view rest(const Words& words) {
    return {words.front().data(), static_cast<std::size_t>(words.back().data() + words.back().size() - words.front().data())};
}

template <class Asks>
Result<Command> read_body(const Entry& entry, const Words& words) {
    if (words.empty()) return wrong(entry, "the body is missing");
    return Asks{std::string(rest(words))};
}

Result<Command> read_change(const Entry& entry, const Words& words) {
    if (words.empty()) return wrong(entry, "the fact is missing");
    return Change{.fact = std::string(rest(words)), .gives = entry.name == "give"};
}

bool all_catoms(const Words& words) {
    return std::ranges::all_of(words, [](std::string_view word) {
        return word.size() > 1 && word.front() == '@' && std::ranges::all_of(word.substr(1), [](char c) { return c >= '0' && c <= '9'; });
    });
}

// @3 @4 ..., each once.
Result<std::vector<std::uint64_t>> read_catoms(const Entry& entry, const Words& words) {
    std::vector<std::uint64_t> ids;
    for (const std::string_view word : words) {
        const Result<std::uint64_t> id = number<std::uint64_t>(entry, word.substr(1), 0);
        if (!id) return tl::unexpected<Error>(id.error());
        if (std::ranges::find(ids, *id) == ids.end()) ids.push_back(*id);
    }
    return ids;
}

Result<Command> read_kill(const Entry& entry, const Words& words) {
    if (words.empty()) return wrong(entry, "the catom is missing");
    Kill asked{.verb = std::string(entry.name)};
    if (!all_catoms(words)) {
        asked.body = std::string(rest(words));
        return asked;
    }
    return read_catoms(entry, words).map([&](std::vector<std::uint64_t> ids) -> Command {
        asked.catoms = std::move(ids);
        return asked;
    });
}

// jam TICKS ..., and the others without ticks: @N, @N @M, around @N @M ..., around BODY.
Result<Command> read_links(const Entry& entry, const Words& all) {
    StrikeLinks asked{.verb = std::string(entry.name)};
    Words words = all;
    if (asked.verb == "jam") {
        if (words.empty()) return wrong(entry, "the number of ticks is missing");
        const Result<std::int64_t> ticks = number<std::int64_t>(entry, words[0], 1);
        if (!ticks) return tl::unexpected<Error>(ticks.error());
        asked.ticks = *ticks;
        words.erase(words.begin());
    }
    asked.around = !words.empty() && words[0] == "around";
    if (asked.around) words.erase(words.begin());
    if (words.empty()) return wrong(entry, "the catom is missing");
    if (asked.around && !all_catoms(words)) {
        asked.body = std::string(rest(words));
        return asked;
    }
    for (const std::string_view word : words)
        if (word.front() != '@') return wrong(entry, fmt::format("{} is no catom", word));
    if (!asked.around && words.size() > 2) return wrong(entry, fmt::format("a link has two catoms, and {} is a third one", words[2]));
    return read_catoms(entry, words).map([&](std::vector<std::uint64_t> ids) -> Command {
        asked.catoms = std::move(ids);
        return asked;
    });
}

// A path may have blanks in it.
Result<Command> read_save_events(const Entry& entry, const Words& words) {
    if (words.empty()) return wrong(entry, "the file is missing");
    return SaveEvents{std::string(rest(words))};
}

template <class Names>
Result<Command> read_branch(const Entry& entry, const Words& words) {
    if (words.empty()) return wrong(entry, "the name of the branch is missing");
    return Names{std::string(words[0])};
}

Result<Command> read_save(const Entry& entry, const Words& words) {
    if (words.empty()) return wrong(entry, "the folder is missing");
    return Save{std::string(rest(words))};
}

Result<Command> read_break(const Entry& entry, const Words& words) {
    if (words.empty()) return wrong(entry, "the rule is missing");
    Break stop{.rule = std::string(words[0])};
    if (words.size() == 1) return stop;
    if (words[1] != "if") return wrong(entry, fmt::format("'{}' is too much", words[1]));
    if (words.size() == 2) return wrong(entry, "the body behind if is missing");
    stop.condition = std::string(rest({words.begin() + 2, words.end()}));
    return stop;
}

Result<Command> read_delete(const Entry& entry, const Words& words) {
    if (words.empty()) return wrong(entry, "the number is missing");
    if (words[0] == "all") return Delete{};
    return number<std::uint64_t>(entry, words[0], 1).map([](std::uint64_t n) -> Command { return Delete{n}; });
}

Result<Command> read_why(const Entry& entry, const Words& words) {
    Why why{.holds = entry.name == "why"};
    std::size_t at = 0;
    for (; at < words.size() && words[at].starts_with("--"); ++at) {
        if (words[at] == "--all") {
            why.all = true;
        } else if (words[at] == "--no-replay" && why.holds) {
            why.replay = false;
        } else if (words[at] == "--depth" && at + 1 < words.size()) {
            const auto depth = number<std::uint64_t>(entry, words[++at], 0);
            if (!depth) return tl::unexpected<Error>(depth.error());
            why.depth = *depth;
        } else {
            return wrong(entry, fmt::format("there is no option {}", words[at]));
        }
    }
    if (at == words.size()) return wrong(entry, "the fact is missing");
    why.fact = std::string(rest({words.begin() + static_cast<std::ptrdiff_t>(at), words.end()}));
    return why;
}

Result<Command> read_history(const Entry& entry, const Words& words) {
    if (words.empty()) return wrong(entry, "the fact is missing");
    return History{std::string(rest(words))};
}

Result<Command> read_messages(const Entry& entry, const Words& words) {
    if (words.empty()) return Messages{};
    if (words[0].front() != '@') return wrong(entry, fmt::format("'{}' is no catom", words[0]));
    return number<std::uint64_t>(entry, words[0].substr(1), 0).map([](std::uint64_t id) -> Command { return Messages{id}; });
}

Result<Command> read_depends(const Entry& entry, const Words& words) {
    Depends asked;
    std::size_t at = 0;
    if (words.size() > 1 && words[0] == "--ticks") {
        const auto ticks = number<std::int64_t>(entry, words[1], 1);
        if (!ticks) return tl::unexpected<Error>(ticks.error());
        asked.ticks = *ticks;
        at = 2;
    }
    if (at == words.size()) return wrong(entry, "the fact is missing");
    asked.fact = std::string(rest({words.begin() + static_cast<std::ptrdiff_t>(at), words.end()}));
    return asked;
}

Result<Command> read_rules(const Entry&, const Words& words) { return Rules{words.empty() ? "" : std::string(words[0])}; }

Result<Command> read_diff(const Entry& entry, const Words& words) {
    if (words.empty()) return Diff{};
    return number<std::int64_t>(entry, words[0], 0).map([](std::int64_t tick) -> Command { return Diff{tick}; });
}

template <class Alone>
Result<Command> read_alone(const Entry&, const Words&) {
    return Alone{};
}

Result<Command> read_help(const Entry&, const Words& words);

constexpr std::size_t kAnyNumber = std::numeric_limits<std::size_t>::max();

constexpr std::array<Entry, 39> kCommands = {{
    {"step", "[N]", "go N ticks forward, or one; Enter alone does the same at the prompt", 1, read_ticks<Step>},
    {"back", "[N]", "go N ticks back, or one", 1, read_ticks<Back>},
    {"to", "T", "go to the end of tick T, forward or back; 0 is the state before the first tick", 1, read_to},
    {"run", "", "go on until nothing is left to do, or to the limits of the run", 0, read_alone<Run>},
    {"reverse", "", "go back to the last tick before this one at which a break or a watch stops, or to the first tick", 0,
     read_alone<Reverse>},
    {"until", "BODY", "go on until a body holds after a tick: until dist(A, D), D > 9", kAnyNumber, read_body<Until>},
    {"break", "RULE [if BODY]", "stop on the way after a tick in which a rule, by its line or its head, fires: break 12 if D > 3",
     kAnyNumber, read_break},
    {"watch", "BODY", "stop on the way after a tick in which a body begins to hold", kAnyNumber, read_body<Watch>},
    {"breaks", "", "the breaks and watches that there are, with their numbers", 0, read_alone<Breaks>},
    {"delete", "N", "drop a break or a watch; delete all drops all of them", 1, read_delete},
    {"give", "FACT", "give a fact at the start of the next tick: give token(@3, 7)", kAnyNumber, read_change},
    {"take", "FACT", "take a fact that was given, at the start of the next tick", kAnyNumber, read_change},
    {"kill", "@N...|BODY", "end these catoms, or those for which a body holds, at the start of the next tick: kill dist(A, D), D > 9",
     kAnyNumber, read_kill},
    {"hang", "@N...|BODY", "the same catoms do nothing any more, from the next tick on", kAnyNumber, read_kill},
    {"restart", "@N...|BODY", "the same catoms begin anew, with the facts of the start, in the next tick", kAnyNumber, read_kill},
    {"cut", "@N [@M]|around @N...|around BODY",
     "cut all links of catom N at the start of the next tick, or that with catom M, or those between several catoms and all others",
     kAnyNumber, read_links},
    {"heal", "@N [@M]|around @N...|around BODY", "bring these links back", kAnyNumber, read_links},
    {"jam", "TICKS @N [@M]|around @N...|around BODY", "nothing arrives over these links for some ticks, beginning with the next one",
     kAnyNumber, read_links},
    {"events", "", "what was done by hand, and in which ticks", 0, read_alone<Events>},
    {"save-events", "FILE", "write that as events of a world", kAnyNumber, read_save_events},
    {"fork", "NAME", "go on from here in a new branch of the run; the present one stays as it is", 1, read_branch<Fork>},
    {"branches", "", "the branches that there are, with their ticks; the first is main", 0, read_alone<BranchList>},
    {"switch", "NAME", "go to where a branch was left", 1, read_branch<Switch>},
    {"reload", "", "go on from here with the program as its file is now", 0, read_alone<Reload>},
    {"save", "DIR", "write what is shown as a checkpoint, for meldsim resume, fork, query and debug", kAnyNumber, read_save},
    {"facts", "[@N] [NAME]", "what holds now: everything, what holds at catom N, or the facts of one predicate", 2, read_facts},
    {"query", "BODY", "all ways to satisfy a body, in Meld: query dist(A, D), D > 9, not leaf(A)", kAnyNumber, read_body<Query>},
    {"why", "[--all] [--depth N] [--no-replay] FACT", "what a fact rests on, down to what was given and sensed: why dist(@42, 7)",
     kAnyNumber, read_why},
    {"why-not", "[--depth N] FACT", "for each rule that could give a fact, the part of its body that fails: why-not dist(@42, 5)",
     kAnyNumber, read_why},
    {"history", "FACT", "the ticks until now in which facts came and went: history dist(@42, _)", kAnyNumber, read_history},
    {"messages", "[@N]", "what crosses all links in this tick, or those of catom N", 1, read_messages},
    {"depends", "[--ticks N] FACT", "what would come and go if a given or linear fact were taken now: depends source(@0)", kAnyNumber,
     read_depends},
    {"rules", "[NAME]", "the rules, with the lines where they stand: all, or those that give facts of one predicate", 1, read_rules},
    {"predicates", "", "what can be asked about: predicates with their declarations", 0, read_alone<Predicates>},
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

std::span<const std::string_view> command_names() { return kNames; }

std::string_view arguments_of(std::string_view command) {
    const auto found = std::ranges::find(kCommands, command, &Entry::name);
    return found != kCommands.end() ? found->arguments : std::string_view();
}

}  // namespace meld::debug
