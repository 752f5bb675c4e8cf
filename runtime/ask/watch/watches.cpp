#include "runtime/ask/watch/watches.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <optional>
#include <utility>

#include "runtime/base/bytes.h"
#include "runtime/base/files/standard_streams.h"
#include "runtime/base/terminal/log.h"
#include "runtime/base/terminal/progress.h"
#include "runtime/base/terminal/terminal_text.h"
#include "runtime/comm/transport/collective_result.h"

namespace meld::inspect {

namespace {

// Of a watch that ends the run or is wrong in one tick, so many lines are printed.
constexpr std::size_t kMostLines = 10;

const char* verb_text(front::WatchRule::Verb verb) {
    switch (verb) {
        case front::WatchRule::Verb::Stop:
            return "stop";
        case front::WatchRule::Verb::Tell:
            return "tell";
        case front::WatchRule::Verb::Expect:
            return "expect";
        case front::WatchRule::Verb::Never:
            return "never";
    }
    return "";
}

std::string holds(const std::string& witness) { return witness.empty() ? "it holds" : witness; }

}  // namespace

std::string Watches::One::name() const { return visible(watch->rule().name.empty() ? watch->rule().body : watch->rule().name); }

Result<std::unique_ptr<Watches>> Watches::make(const ModuleInfo& module, std::vector<front::WatchRule> rules, std::FILE* to) {
    std::unique_ptr<Watches> all(new Watches(to));
    for (front::WatchRule& rule : rules) {
        Result<std::unique_ptr<Watch>> watch = Watch::make(module, std::move(rule));
        if (!watch) return tl::unexpected<Error>(watch.error());
        all->watches_.push_back({.watch = std::move(*watch)});
        const One& one = all->watches_.back();
        all->outcomes_.push_back({.name = one.name(), .verb = verb_text(one.watch->rule().verb)});
    }
    return all;
}

// ---- what holds

void Watches::Held::add(std::string key, Way way) {
    const auto [at, is_new] = ways.emplace(std::move(key), std::move(way));
    if (!is_new) return;
    ++texts[at->second.text];
    ++homes[at->second.home];
    for (const u64 catom : at->second.catoms) keys.emplace(catom, at->first);
}

void Watches::Held::remove(const std::string& key) {
    const auto at = ways.find(key);
    if (at == ways.end()) return;
    if (--texts[at->second.text] == 0) texts.erase(at->second.text);
    if (const auto home = homes.find(at->second.home); --home->second == 0) {
        left.push_back(home->first);
        homes.erase(home);
    }
    for (const u64 catom : at->second.catoms) keys.erase({catom, at->first});
    ways.erase(at);
}

Watches::Held::Way Watches::held_way(One& one, const Watch::Way& way) {
    return {.text = way.text, .catoms = one.watch->catoms_of(way), .home = one.watch->home_of(way).value_or(kNowhere)};
}

std::optional<Watches::Where> Watches::holding(std::size_t number) const {
    const One& one = watches_[number];
    const Held& held = one.held;
    if (held.homes.empty()) return std::nullopt;
    const u64 least = held.homes.begin()->first;
    std::optional<Watch::Way> first;
    for (const auto& [key, each] : held.ways) {
        if (each.home != least) continue;
        Watch::Way way = one.watch->way_of(key, each.text);
        if (!first || one.watch->before(way, *first)) first = std::move(way);
    }
    if (least == kNowhere) return Where{.witness = one.watch->told(*first)};
    return Where{.catom = least, .catoms = held.homes.size(), .witness = one.watch->told(*first)};
}

std::optional<Watches::Where> Watches::lost(std::size_t number) const {
    const Held& held = watches_[number].held;
    std::set<u64> gone(held.left.begin(), held.left.end());
    std::erase_if(gone, [&](u64 home) { return held.homes.contains(home); });
    if (gone.empty()) return std::nullopt;
    if (*gone.begin() == kNowhere) return Where{};
    return Where{.catom = *gone.begin(), .catoms = gone.size()};
}

// What holds now and is told of nothing that held before; ways from the catoms that were looked at hold no more unless they were found.
std::vector<std::string> Watches::news(One& one, const Watch::Found& found) {
    Held& held = one.held;
    std::vector<std::string> gone;
    std::unordered_map<std::string_view, const Watch::Way*> now;
    for (const Watch::Way& way : found.ways) now.emplace(way.key, &way);
    if (found.whole) {
        for (const auto& [key, way] : held.ways)
            if (!now.contains(key)) gone.push_back(key);
    } else {
        for (const u64 catom : found.from)
            for (auto at = held.keys.lower_bound({catom, {}}); at != held.keys.end() && at->first == catom; ++at)
                if (!now.contains(at->second)) gone.emplace_back(at->second);
    }
    std::vector<std::string> lines;
    for (const Watch::Way& way : found.ways) {
        if (held.ways.contains(way.key)) continue;
        if (!held.texts.contains(way.text)) lines.push_back(way.text);
        held.add(way.key, held_way(one, way));
    }
    for (const std::string& key : gone) held.remove(key);
    return lines;
}

// A catom that is no more changes nothing at others that are not its neighbours.
void Watches::forget_removed(sim::Subdomain& subdomain) {
    ByteWriter kept;
    if (subdomain.comm.process() == 0)
        for (const One& one : watches_) {
            std::optional<u64> last;
            for (const auto& [catom, key] : one.held.keys)
                if (std::exchange(last, catom) != catom) kept.write(catom);
        }
    const auto all = subdomain.comm.allgather_any(kept.view());
    ByteWriter here;
    for (ByteReader in(all[0], "catoms of what is watched"); !in.done();) {
        const u64 catom = in.read<u64>();
        const auto found = subdomain.ensemble.find(catom);
        if (found && subdomain.owned(*found)) here.write(catom);
    }
    std::unordered_set<u64> exist;
    for (const auto& bytes : subdomain.comm.allgather_any(here.view()))
        for (ByteReader in(bytes, "catoms that there are"); !in.done();) exist.insert(in.read<u64>());
    for (One& one : watches_) {
        std::vector<std::string> gone;
        for (const auto& [catom, key] : one.held.keys)
            if (!exist.contains(catom)) gone.emplace_back(key);
        for (const std::string& key : gone) one.held.remove(key);
    }
}

// ---- a tick

Changes Watches::changes_in(sim::Subdomain& subdomain, bool had_asked) {
    Changes out{.everything = !std::exchange(begun_, true)};
    const auto id = [&](sim::Catom catom) { return subdomain.ensemble.id(catom); };
    const std::vector<u64> asked = std::exchange(asking_, {});
    for (const eval::Action& action : subdomain.actions())
        if (asking_.empty() || asking_.back() != id(action.catom)) asking_.push_back(id(action.catom));
    if (out.everything) return out;
    out.mostly = subdomain.totals.tick.awake > subdomain.totals.catoms / 4;
    if (had_asked)
        for (const u64 catom : asked)
            if (const auto found = subdomain.ensemble.find(catom)) out.had_asked.push_back(*found);
    return out;
}

// Up to date, or null if no search needs them. Who only asks now and then, as the debugger, would leave followers behind.
Holders* Watches::holders(sim::Subdomain& subdomain) {
    if (!in_run_) return nullptr;
    std::vector<u32> predicates;
    for (const One& one : watches_)
        for (const u32 predicate : one.watch->looked_for())
            if (std::ranges::find(predicates, predicate) == predicates.end()) predicates.push_back(predicate);
    if (predicates.empty()) return nullptr;
    if (!holders_) holders_.emplace(subdomain, std::move(predicates));
    holders_->update();
    return &*holders_;
}

Result<void> Watches::search(sim::Subdomain& subdomain, const Changes& changes, const std::vector<std::size_t>& which,
                             std::vector<Watch::Found>& found) {
    SharedFacts facts(subdomain, holders(subdomain));
    for (const std::size_t i : which) watches_[i].watch->begin(subdomain, changes, !watches_[i].remembers());
    Result<void> outcome;
    do {
        for (const std::size_t i : which)
            if (auto done = watches_[i].watch->go_on(facts); !done && outcome) outcome = done;
    } while (facts.fetch());
    ByteWriter mine;
    for (const std::size_t i : which) watches_[i].watch->found(subdomain, mine);
    std::vector<comm::Packet> packets;
    found.assign(which.size(), {});
    const auto add = [&](std::span<const std::byte> bytes) {
        ByteReader in(bytes, "what a watch has found");
        for (std::size_t k = 0; k < which.size(); ++k) watches_[which[k]].watch->add(in, found[k]);
    };
    const bool first = subdomain.comm.process() == 0;
    if (!first) packets.push_back({0, mine.take()});
    if (!subdomain.alone()) packets = subdomain.comm.exchange(std::move(packets));
    if (!first) return outcome;
    add(mine.view());
    for (const comm::Packet& packet : packets) add(packet.bytes);
    for (std::size_t k = 0; k < which.size(); ++k) {
        watches_[which[k]].watch->finish(found[k]);
        watches_[which[k]].incomplete = watches_[which[k]].incomplete || found[k].failures > 0;
    }
    return outcome;
}

Result<Watches::Looked> Watches::look(sim::Subdomain& subdomain) {
    const sim::Totals& totals = subdomain.totals;
    for (One& one : watches_) one.held.left.clear();
    // The same on all processes, so that all search or none does.
    const std::uint64_t gone = subdomain.next_id() - totals.catoms;
    const bool removed = std::exchange(gone_, gone) != gone;
    const bool had_asked = std::exchange(asked_, totals.actions > 0);
    std::vector<std::size_t> which;
    for (std::size_t i = 0; i < watches_.size(); ++i) {
        const One& one = watches_[i];
        const bool changed = !begun_ || totals.tick.awake > 0 || removed || had_asked || one.watch->may_always_change(subdomain);
        if (changed && !one.over && one.watch->rule().verb != Verb::Expect) which.push_back(i);
    }
    if (which.empty()) return Looked{};
    if (removed) forget_removed(subdomain);
    std::vector<Watch::Found> found;
    Result<void> outcome = search(subdomain, changes_in(subdomain, had_asked), which, found);
    if (auto all = comm::outcome_of_all(subdomain.comm, outcome); !all) return tl::unexpected<Error>(all.error());
    Looked looked{.searched = true};
    for (std::size_t k = 0; k < which.size() && subdomain.comm.process() == 0; ++k) {
        One& one = watches_[which[k]];
        News news{.watch = which[k]};
        if (one.remembers())
            news.lines = this->news(one, found[k]);
        else if (!found[k].ways.empty())
            news.lines = {found[k].ways[0].text};
        if (news.lines.empty()) continue;
        const Watch::Way& first = *std::ranges::find(found[k].ways, news.lines[0], &Watch::Way::text);
        news.first = {.body = one.watch->rule().body, .catom = one.watch->home_of(first).value_or(0), .values = one.watch->told(first)};
        looked.news.push_back(std::move(news));
    }
    return looked;
}

Result<void> Watches::after(sim::Subdomain& subdomain) {
    caught_now_.reset();
    in_run_ = true;
    const Result<Looked> looked = look(subdomain);
    if (!looked) return tl::unexpected<Error>(looked.error());
    if (!looked->searched) return {};
    bool stop = false;
    Result<void> outcome;
    for (const News& news : looked->news) {
        One& one = watches_[news.watch];
        if (outcome) outcome = tell(subdomain, news.watch, news.lines);
        stop = stop || one.watch->rule().verb == Verb::Stop;
        one.over = one.watch->rule().verb == Verb::Never;
        if (caught_ || caught_now_ || one.watch->rule().verb == Verb::Tell) continue;
        caught_now_ = news.watch;
        witness_ = news.first;
    }
    return agree(subdomain, stop, outcome);
}

Result<void> Watches::tell(sim::Subdomain& subdomain, std::size_t number, const std::vector<std::string>& lines) {
    const One& one = watches_[number];
    Outcome& outcome = outcomes_[number];
    const bool tells = one.watch->rule().verb == Verb::Tell;
    const std::size_t shown = tells ? lines.size() : std::min(lines.size(), kMostLines);
    std::string text;
    for (std::size_t i = 0; i < shown; ++i)
        text += fmt::format("tick {}: {}{}{}\n", subdomain.tick(), one.name(), lines[i].empty() ? "" : ": ", lines[i]);
    if (shown < lines.size()) text += fmt::format("tick {}: {}: and {} more\n", subdomain.tick(), one.name(), lines.size() - shown);
    outcome.lines += lines.size();
    if (!tells) {
        outcome.wrong = true;
        outcome.found = fmt::format("tick {}: {}", subdomain.tick(), holds(lines[0]));
    }
    clear_progress();
    return print(to_, text);
}

// What process 0 has seen, on all.
Result<void> Watches::agree(sim::Subdomain& subdomain, bool stop, const Result<void>& mine) {
    if (!subdomain.alone()) {
        ByteWriter out;
        if (subdomain.comm.process() == 0) {
            out.write(stop);
            for (const One& one : watches_) out.write(one.over);
            for (const Outcome& outcome : outcomes_) out.write(outcome.wrong);
            out.write(caught_now_.has_value());
            out.write(static_cast<u64>(caught_now_.value_or(0)));
        }
        const auto all = subdomain.comm.allgather_any(out.view());
        ByteReader in(all[0], "what watches say");
        stop = in.read<bool>();
        for (One& one : watches_) one.over = in.read<bool>();
        for (Outcome& outcome : outcomes_) outcome.wrong = in.read<bool>();
        const bool caught = in.read<bool>();
        const u64 number = in.read<u64>();
        caught_now_ = caught ? std::optional<std::size_t>(number) : std::nullopt;
    }
    caught_ = caught_ || caught_now_;
    any_wrong_ = std::ranges::any_of(outcomes_, &Outcome::wrong);
    if (stop) subdomain.end_here();
    return comm::outcome_of_first(subdomain.comm, mine);
}

Result<void> Watches::explain(std::size_t number, const std::string& why) {
    outcomes_[number].found += "\n" + why;
    return print(to_, why);
}

Result<void> Watches::at_end(sim::Subdomain& subdomain) {
    std::vector<std::size_t> which;
    for (std::size_t i = 0; i < watches_.size(); ++i)
        if (watches_[i].watch->rule().verb == Verb::Expect) which.push_back(i);
    std::vector<Watch::Found> found;
    Result<void> outcome;
    if (!which.empty()) outcome = search(subdomain, {.everything = true}, which, found);
    if (auto all = comm::outcome_of_all(subdomain.comm, outcome); !all) return all;
    for (std::size_t k = 0; k < which.size() && subdomain.comm.process() == 0; ++k) {
        if (!found[k].ways.empty()) continue;
        outcomes_[which[k]].wrong = true;
        outcomes_[which[k]].found = fmt::format("it does not hold at the end, after tick {}", subdomain.tick());
        clear_progress();
        const std::string text = fmt::format("tick {}: expected, and it does not hold: {}\n", subdomain.tick(), watches_[which[k]].name());
        if (auto printed = print(to_, text); !printed && outcome) outcome = printed;
    }
    for (const One& one : watches_)
        if (one.incomplete)
            log::warning("{}: values could not be computed while this was searched, so something may be missing", one.name());
    return agree(subdomain, false, outcome);
}

// ---- checkpoints: a watch is known again by what it says, and among several that say the same by their order

std::string Watches::what_it_says(std::size_t number) const {
    const front::WatchRule& rule = watches_[number].watch->rule();
    return fmt::format("{} {}({}) {}", outcomes_[number].verb, watches_[number].name(), fmt::join(rule.shown, ", "), rule.body);
}

void Watches::save_rest(const sim::Subdomain& subdomain, ByteWriter& out) const {
    if (subdomain.comm.process() != 0) return;
    out.write_count(watches_.size());
    for (std::size_t i = 0; i < watches_.size(); ++i) {
        const One& one = watches_[i];
        const bool lasts = one.watch->rule().verb != Verb::Stop;  // One that has stopped the run does not stop it as soon as it goes on.
        out.write_string(what_it_says(i));
        const std::size_t block = out.begin_block();
        out.write(one.over);
        out.write(lasts && outcomes_[i].wrong);
        out.write_string(lasts ? outcomes_[i].found : "");
        out.write(outcomes_[i].lines);
        out.write_count(one.held.ways.size());
        for (const auto& [key, way] : one.held.ways) {
            out.write_string(key);
            out.write_string(way.text);
        }
        out.end_block(block);
    }
}

Result<void> Watches::load_rest(sim::Subdomain& subdomain, ByteReader& in) {
    if (in.done()) return {};
    std::vector<bool> known(watches_.size());
    for (auto left = in.read_count(2 * sizeof(u32)); left > 0; --left) {
        const std::string what = in.read_string();
        ByteReader state(in.read_block(), "a watch");
        for (std::size_t i = 0; i < watches_.size(); ++i) {
            One& one = watches_[i];
            Outcome& outcome = outcomes_[i];
            if (known[i] || what != what_it_says(i)) continue;
            known[i] = true;
            one.over = state.read<bool>();
            outcome.wrong = state.read<bool>();
            outcome.found = state.read_string();
            outcome.lines = state.read<std::uint64_t>();
            any_wrong_ = any_wrong_ || outcome.wrong;
            caught_ = any_wrong_;
            for (auto ways = state.read_count(2 * sizeof(u32)); ways > 0; --ways) {
                std::string key = state.read_string();
                std::string text = state.read_string();
                if (subdomain.comm.process() != 0) continue;
                const Watch::Way way = one.watch->way_of(std::move(key), std::move(text));
                one.held.add(way.key, held_way(one, way));
            }
            break;
        }
    }
    return {};
}

}  // namespace meld::inspect
