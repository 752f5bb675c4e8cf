#include "runtime/sim/core/divergence_report.h"

#include <fmt/format.h>

#include <algorithm>
#include <iterator>
#include <limits>
#include <string_view>

#include "runtime/base/assert.h"
#include "runtime/base/bytes.h"
#include "runtime/engine/tuple/facts.h"
#include "runtime/sim/core/subdomain.h"

namespace meld::sim {

namespace {

// The number of hashes stored at a time: 64 MiB.
constexpr u64 kMaxHashes = u64{1} << 24;
// A predicate that has not changed for this many ticks counts as quiescent, and such a catom is no longer used as an example.
constexpr i64 kPatience = 32;
constexpr std::size_t kShownChanges = 3, kShownFacts = 3, kShownPredicates = 6, kShownRules = 6;

bool shown(const PredicateInfo& p) { return !p.auxiliary && p.column != kNone16 && p.kind != PredicateKind::Action; }

std::string count_of(u64 n, std::string_view what) { return fmt::format("{} {}{}", n, what, n == 1 ? "" : "s"); }

void add_facts(std::string& text, char sign, const std::vector<std::string>& facts) {
    for (std::size_t i = 0; i < std::min(facts.size(), kShownFacts); ++i) text += fmt::format(" {} {}", sign, facts[i]);
    if (facts.size() > kShownFacts) text += fmt::format(" {} {} more", sign, facts.size() - kShownFacts);
}

}  // namespace

Unsettled::Unsettled(const ModuleInfo& module) : module_(module) {
    for (u32 p = 0; p < module.predicate_count; ++p)
        if (shown(module.predicates[p])) followed_.push_back({.predicate = p});
}

std::vector<std::string> Unsettled::facts_of(const Subdomain& subdomain, u32 predicate, u32 catom) const {
    std::vector<std::string> facts;
    const PredicateInfo& p = module_.predicates[predicate];
    tuple::each_fact(module_, subdomain.columns, subdomain.geometry(), predicate, catom,
                     [&](const Value* v) { facts.push_back(tuple::print_fact(module_, p, subdomain.ensemble.id(catom), v)); });
    std::sort(facts.begin(), facts.end());
    return facts;
}

// A hash of the facts that does not depend on their order.
u32 Unsettled::hash_of(const Subdomain& subdomain, u32 predicate, u32 catom) const {
    u64 sum = 0;
    tuple::each_fact(module_, subdomain.columns, subdomain.geometry(), predicate, catom,
                     [&](const Value* v) { sum += tuple::hash_arguments(module_, module_.predicates[predicate], 1, v); });
    return static_cast<u32>(sum ^ sum >> 32);
}

void Unsettled::before(Subdomain& subdomain) {
    subdomain.refresh();
    ++looked_;
    stride_ = 1 + subdomain.totals.tick.awake * followed_.size() / kMaxHashes;
    awake_.clear();
    hashes_.clear();
    subdomain.agenda().each([&](u32 catom, u64) {
        if (subdomain.owned(catom) && subdomain.ensemble.id(catom) % stride_ == 0) awake_.push_back({catom, subdomain.ensemble.id(catom)});
    });
    for (const Seen& s : awake_)
        for (const Followed& f : followed_) hashes_.push_back(hash_of(subdomain, f.predicate, s.catom));
    for (Followed& f : followed_) {
        const auto catom = f.id == kNobody ? std::nullopt : subdomain.ensemble.find(f.id);
        if (catom && subdomain.owned(*catom)) f.facts = facts_of(subdomain, f.predicate, *catom);
    }
}

void Unsettled::after(Subdomain& subdomain) {
    subdomain.refresh();
    // For each predicate: at how many catoms it has changed, the least of them, and whether the followed one has.
    struct News {
        u64 count = 0;
        u64 least = kNobody;
        bool followed = false;
    };
    std::vector<News> news(followed_.size());
    MELD_EXPECT(hashes_.size() == awake_.size() * followed_.size(), "{} hashes of {} catoms", hashes_.size(), awake_.size());
    const u32* hash = hashes_.data();
    for (const Seen& s : awake_)
        for (std::size_t i = 0; i < followed_.size(); ++i) {
            if (*hash++ == hash_of(subdomain, followed_[i].predicate, s.catom)) continue;
            ++news[i].count;
            news[i].least = std::min(news[i].least, s.id);
            news[i].followed = news[i].followed || s.id == followed_[i].id;
        }
    ByteWriter mine;
    for (const News& n : news) mine.write(n);
    for (std::size_t other = 0; const std::vector<std::byte>& bytes : subdomain.comm.allgather_any(mine.view())) {
        if (static_cast<int>(other++) == subdomain.comm.process()) continue;
        ByteReader in(bytes, "what changes still");
        for (News& n : news) {
            const auto theirs = in.read<News>();
            n.count += theirs.count;
            n.least = std::min(n.least, theirs.least);
            n.followed = n.followed || theirs.followed;
        }
    }
    for (std::size_t i = 0; i < followed_.size(); ++i) {
        Followed& f = followed_[i];
        if (news[i].count == 0) continue;
        ++f.ticks;
        f.last = subdomain.tick();
        f.most = std::max(f.most, news[i].count * stride_);
        note_changes(subdomain, f, news[i].followed);
        if (news[i].followed) f.moved = subdomain.tick();
        if (f.id != kNobody && subdomain.tick() - f.moved < kPatience) continue;
        f.id = news[i].least;
        f.moved = subdomain.tick();
        f.changes.clear();
    }
}

void Unsettled::note_changes(Subdomain& subdomain, Followed& f, bool changed) {
    const auto catom = f.id == kNobody || !changed ? std::nullopt : subdomain.ensemble.find(f.id);
    if (!catom || !subdomain.owned(*catom)) return;
    const std::vector<std::string> now = facts_of(subdomain, f.predicate, *catom);
    MELD_EXPECT(std::is_sorted(f.facts.begin(), f.facts.end()), "facts of @{} out of order", f.id);
    std::vector<std::string> gone, come;
    std::set_difference(f.facts.begin(), f.facts.end(), now.begin(), now.end(), std::back_inserter(gone));
    std::set_difference(now.begin(), now.end(), f.facts.begin(), f.facts.end(), std::back_inserter(come));
    std::string text;
    add_facts(text, '-', gone);
    add_facts(text, '+', come);
    if (f.changes.size() == kShownChanges) f.changes.erase(f.changes.begin());
    f.changes.push_back({subdomain.tick(), std::move(text)});
}

// From all processes: the catom may have migrated.
std::string Unsettled::changes_of(Subdomain& subdomain, const Followed& f) const {
    ByteWriter mine;
    for (const Change& c : f.changes) {
        mine.write(c.tick);
        mine.write_string(c.text);
    }
    std::vector<Change> all;
    for (const std::vector<std::byte>& bytes : subdomain.comm.allgather_any(mine.view())) {
        ByteReader in(bytes, "what changes still");
        while (!in.done()) {
            const i64 tick = in.read<i64>();
            all.push_back({tick, in.read_string()});
        }
    }
    std::sort(all.begin(), all.end(), [](const Change& a, const Change& b) { return a.tick < b.tick; });
    std::string text;
    for (std::size_t i = all.size() - std::min(all.size(), kShownChanges); i < all.size(); ++i)
        text += fmt::format("\n    tick {}:{}", all[i].tick, all[i].text);
    return text;
}

std::string Unsettled::rules_of(u32 predicate) const {
    std::vector<std::string> rules;
    for (u32 r = 0; r < module_.rule_count; ++r) {
        const RuleInfo& rule = module_.rules[r];
        if (std::find(rule.heads, rule.heads + rule.head_count, predicate) == rule.heads + rule.head_count) continue;
        const std::string text = fmt::format("{}:{}: {}", rule.file, rule.line, rule.text);
        if (std::find(rules.begin(), rules.end(), text) == rules.end()) rules.push_back(text);
    }
    std::string text;
    for (std::size_t i = 0; i < std::min(rules.size(), kShownRules); ++i) text += "\n    " + rules[i];
    if (rules.size() > kShownRules) text += fmt::format("\n    and {}", count_of(rules.size() - kShownRules, "more rule"));
    return text;
}

// Facts that are stored for a later tick, `p` in a predicate of the compiler called p@later.
std::string Unsettled::waiting(Subdomain& subdomain) const {
    std::string text;
    for (u32 p = 0; p < module_.predicate_count; ++p) {
        const std::string_view name = module_.predicates[p].name;
        if (!module_.predicates[p].auxiliary || !name.ends_with("@later")) continue;
        u64 catoms = 0;
        for (u32 catom = 0; catom < subdomain.ensemble.index_count(); ++catom) {
            bool any = false;
            if (subdomain.owned(catom))
                tuple::each_fact(module_, subdomain.columns, subdomain.geometry(), p, catom, [&](const Value*) { any = true; });
            catoms += any;
        }
        ByteWriter mine;
        mine.write(catoms);
        catoms = 0;
        for (const std::vector<std::byte>& bytes : subdomain.comm.allgather_any(mine.view())) {
            ByteReader in(bytes, "what changes still");
            catoms += in.read<u64>();
        }
        if (catoms == 0) continue;
        const std::string_view of = name.substr(0, name.find('@'));
        text += fmt::format("\n  `{}` waits for its time at {}", of, count_of(catoms, "catom"));
        for (u32 q = 0; q < module_.predicate_count; ++q)
            if (of == module_.predicates[q].name) text += rules_of(q);
    }
    return text;
}

// A delayed view, or the end of a quarantine.
std::string Unsettled::next_timer(Subdomain& subdomain) const {
    ByteWriter mine;
    mine.write(subdomain.timers().empty() ? std::numeric_limits<i64>::max() : subdomain.timers().next());
    i64 next = std::numeric_limits<i64>::max();
    for (const std::vector<std::byte>& bytes : subdomain.comm.allgather_any(mine.view())) {
        ByteReader in(bytes, "what changes still");
        next = std::min(next, in.read<i64>());
    }
    return next == std::numeric_limits<i64>::max() ? "" : fmt::format("\n  The next delayed fact arrives in tick {}", next);
}

std::string Unsettled::describe(Subdomain& subdomain) const {
    std::vector<const Followed*> changing;
    i64 last = 0;
    for (const Followed& f : followed_) last = std::max(last, f.last);
    // Predicates that have not changed for long are left out.
    for (const Followed& f : followed_)
        if (f.ticks > 0 && f.last > last - kPatience) changing.push_back(&f);
    std::stable_sort(changing.begin(), changing.end(),
                     [](const Followed* a, const Followed* b) { return std::pair(a->last, a->ticks) > std::pair(b->last, b->ticks); });
    const std::string pending = waiting(subdomain);
    std::string text =
        fmt::format("In the last {}{}", count_of(static_cast<u64>(looked_), "tick"), changing.empty() ? " no fact came or went" : "");
    for (std::size_t i = 0; i < std::min(changing.size(), kShownPredicates); ++i) {
        const Followed& f = *changing[i];
        text += fmt::format("\n  `{}` changed in {}, at up to {} in one; at @{}:", module_.predicates[f.predicate].name,
                            f.ticks == looked_ ? std::string("each") : fmt::format("{}", f.ticks), count_of(f.most, "catom"), f.id);
        text += changes_of(subdomain, f);
        text += rules_of(f.predicate);
    }
    if (changing.size() > kShownPredicates)
        text += fmt::format("\n  and {}", count_of(changing.size() - kShownPredicates, "more predicate"));
    text += pending;
    if (changing.empty() && pending.empty()) text += next_timer(subdomain);
    if (module_.reads_tick) text += "\n  The program reads `tick`, which is new in each: it ends with --ticks, or with stop-program";
    if (subdomain.status().moving) text += "\n  Bodies were moving";
    return text;
}

}  // namespace meld::sim
