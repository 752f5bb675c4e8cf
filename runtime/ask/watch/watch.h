// A body that is searched after every tick, at the cost of what has changed in it.
//
// A body begins to hold only if a fact that one of its atoms reads has come, gone or changed at that atom's catom. So it is searched from
// the catoms at which that may be so: with each in turn as the catom of each atom. The rest follows over links. A sieve (sieve.h) finds the
// few of them from which there may be a way.
#pragma once

#include <map>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <unordered_set>
#include <utility>
#include <vector>

#include "compiler/front/watch_rules.h"
#include "runtime/ask/facts/program.h"
#include "runtime/ask/facts/shared_facts.h"
#include "runtime/ask/query/sieve.h"
#include "runtime/ask/query/terms.h"
#include "runtime/sim/core/subdomain.h"

namespace meld::inspect {

// The catoms of this process at which facts may have changed in a tick, beside those that were evaluated.
struct Changes {
    bool everything = false;          // A search begins, so nothing is known of the tick before.
    bool mostly = false;              // So many that looking at all is no more work.
    std::vector<u32> had_asked = {};  // Their actions of the tick before are over.
};

class Watch {
  public:
    // Errors: mistakes in the body, with their places; it asks for what the run does not have; a variable that is told has no value.
    static Result<std::unique_ptr<Watch>> make(const ModuleInfo& module, front::WatchRule rule);

    const front::WatchRule& rule() const { return rule_; }
    // The body may hold differently in every tick, whatever is evaluated: free catoms also move while they sense nothing of it.
    bool may_always_change(const sim::Subdomain& subdomain) const {
        return reads_ticks_ || (reads_places_ && subdomain.ensemble.is_free());
    }

    // The predicates whose facts a search may have to find wherever they are, beside those that lead over links from a change.
    std::vector<u32> looked_for() const;

    // A way to satisfy the body.
    struct Way {
        std::vector<Value> values = {};  // By column.
        std::string key = {};            // They as bytes.
        std::string text = {};           // What is told of them: A = @3, D = 7.
    };
    // What was found, which is all that is new, and perhaps more that holds.
    struct Found {
        std::vector<Way> ways = {};
        bool whole = false;          // All ways there are.
        std::vector<u64> from = {};  // Else: all that have one of these catoms in an atom.
        u64 failures = 0;            // Values that could not be computed.
    };

    // A search of all processes: begin(), then go_on() as long as facts come from others, then found(). With `least` only the first way
    // in their order is kept.
    void begin(sim::Subdomain& subdomain, const Changes& changes, bool least);
    Result<void> go_on(SharedFacts& facts);
    void found(const sim::Subdomain& subdomain, ByteWriter& out);
    // What found() of a process has written is added.
    void add(ByteReader& in, Found& all);
    // Puts ways in order, each once.
    void finish(Found& all) const;
    // The catoms of its atoms.
    std::vector<u64> catoms_of(const Way& way) const;
    Way way_of(std::string key, std::string text);
    // The catom of the body's first fact; nothing if it has none, outside `not` and aggregates.
    std::optional<u64> home_of(const Way& way);
    // The body's variables and their values, as Meld, without that catom.
    using Told = std::vector<std::pair<std::string, std::string>>;
    Told told(const Way& way) const;
    // Whether a way comes before another one.
    bool before(const Way& a, const Way& b) const { return compare(a.values, b.values) < 0; }

  private:
    Watch(Program program, front::WatchRule rule);
    Result<void> find_columns();
    void find_starts();
    using Distances = std::map<check::VariableId, std::size_t>;
    void look(const std::vector<check::Clause>& clauses, Distances near, bool inside);
    void note_reads(const check::Atom& atom);
    void add_stored(const std::vector<check::Clause>& clauses, std::vector<u32>& predicates) const;
    bool follows_links(check::VariableId start) const;
    void note(const Values& values);
    std::vector<u32> starts_of(sim::Subdomain& subdomain, const Changes& changes) const;
    void add_neighbours(sim::Subdomain& subdomain, std::vector<u32>& catoms) const;
    const check::Clause* first_fact() const;
    int compare(const std::vector<Value>& a, const std::vector<Value>& b) const;
    std::string text_of(const std::vector<Value>& values) const;
    std::vector<Value> unpack(std::span<const std::byte> key);

    Program program_;
    front::WatchRule rule_;
    Types types_;
    std::vector<check::VariableId> columns_;
    std::size_t answers_ = 0;  // The first columns are the body's variables.
    std::vector<tuple::Type> column_types_;
    std::vector<std::size_t> shown_;         // Columns.
    std::vector<check::VariableId> starts_;  // The catoms of atoms, which are columns too.
    std::vector<std::size_t> start_columns_;
    bool anywhere_ = false;    // What it reads may be at catoms that are no start.
    bool links_only_ = false;  // From a start everything else is reached over links.
    bool reads_ticks_ = false, reads_places_ = false, reads_linear_ = false, reads_actions_ = false;
    // What it reads may change in any evaluation of a catom; else only when one of these exported columns changes, or for these reasons.
    bool reads_private_ = false;
    std::vector<bool> columns_read_;
    u64 reasons_ = 0;
    std::size_t reach_ = 0;  // What is at a catom also matters to those that are so many links away.

    // Of the present search.
    std::optional<Terms> terms_;
    std::vector<Sieve> sieves_;  // By start.
    bool whole_ = false, pending_whole_ = false, least_ = false;
    std::vector<u32> from_;
    std::vector<std::vector<u64>> pending_;  // By start.
    std::vector<Way> ways_;
    std::unordered_set<std::string> keys_;
    std::vector<Way> of_one_;  // Found from one catom, until it is known that nothing was lacking.
    u64 failures_ = 0;         // Of these searches.
    tuple::Arena lists_;
};

}  // namespace meld::inspect
