// What is watched in a run, after every tick, on all processes: it sees the state between two ticks and changes nothing.
#pragma once

#include <cstdint>
#include <cstdio>
#include <map>
#include <memory>
#include <optional>
#include <set>
#include <string>
#include <string_view>
#include <unordered_map>
#include <utility>
#include <vector>

#include "runtime/ask/facts/holders.h"
#include "runtime/ask/query/witness.h"
#include "runtime/ask/watch/watch.h"
#include "runtime/sim/core/extension.h"

namespace meld::inspect {

class Watches : public sim::SimModule {
  public:
    using Verb = front::WatchRule::Verb;

    // Errors: those of Watch::make(). Process 0 writes the lines.
    static Result<std::unique_ptr<Watches>> make(const ModuleInfo& module, std::vector<front::WatchRule> rules, std::FILE* to);

    // What is new after a tick: of stop and tell the ways in which the body holds and did not before, of never the first one of those.
    struct News {
        std::size_t watch = 0;  // Its number among the rules.
        std::vector<std::string> lines = {};
        Witness first = {};  // Of the first line.
    };
    struct Looked {
        bool searched = false;        // The same on all processes; otherwise nothing can have changed.
        std::vector<News> news = {};  // On process 0.
    };
    // Looks at the state after a tick, and prints nothing. Every process calls it, after every tick of one run; after the first of them,
    // all that holds is new. Errors, the same on every process: those of the search.
    Result<Looked> look(sim::Subdomain& subdomain);

    // Where the body of a stop or tell holds after look(), by the catom of its first fact; nothing if nowhere. On process 0.
    struct Where {
        std::optional<u64> catom = {};  // The least; nothing if the body has no such fact.
        u64 catoms = 0;                 // How many there are.
        Watch::Told witness = {};       // The first way there.
    };
    std::optional<Where> holding(std::size_t number) const;
    // The catoms at which it held before the last look() and holds in no way now; without a witness. On process 0.
    std::optional<Where> lost(std::size_t number) const;

    // As part of a run: looks, and prints what is new. Bodies of facts that few catoms hold cost their number.
    Result<void> after(sim::Subdomain& subdomain) override;
    // After the last tick of a run that ended well: looks for what must hold there. Every process calls it.
    Result<void> at_end(sim::Subdomain& subdomain);

    // How it went with each, on process 0; the state of a watch is known once at_end() has looked.
    struct Outcome {
        std::string name;         // Its own, or the body.
        const char* verb = "";    // As it is written.
        bool wrong = false;       // The run is not as wanted.
        std::string found = {};   // Of one that is wrong: what, and where; on further lines why, if it is known.
        std::uint64_t lines = 0;  // That tell has printed.
    };
    const std::vector<Outcome>& outcomes() const { return outcomes_; }
    // Some watch says that the run is not as wanted; on all processes.
    bool any_wrong() const { return any_wrong_; }

    // After the tick in which the first of --watch and --never found the run not as wanted: its number. On all processes the same.
    std::optional<std::size_t> caught_now() const { return caught_now_; }
    // What it found then, on process 0.
    const Witness& witness() const { return witness_; }
    // Why it holds, to be printed below, and to be kept with what was found. Errors: the line cannot be written.
    Result<void> explain(std::size_t number, const std::string& why);

    Result<void> saveable() const override { return {}; }
    void save_rest(const sim::Subdomain& subdomain, ByteWriter& out) const override;
    Result<void> load_rest(sim::Subdomain& subdomain, ByteReader& in) override;

  private:
    static constexpr u64 kNowhere = ~u64{0};
    // What holds, as far as it has been told: on process 0.
    struct Held {
        struct Way {
            std::string text;
            std::vector<u64> catoms;
            u64 home = kNowhere;
        };
        std::map<std::string, Way> ways;                  // By key.
        std::set<std::pair<u64, std::string_view>> keys;  // By catom: those of `ways`.
        std::unordered_map<std::string, u64> texts;       // How many ways say the same.
        std::map<u64, u64> homes;                         // How many ways there are with this one.
        std::vector<u64> left;                            // In this look some way was the last one there.
        void add(std::string key, Way way);
        void remove(const std::string& key);
    };
    struct One {
        std::unique_ptr<Watch> watch;
        bool over = false;  // It has nothing more to say; on all processes.
        Held held = {};
        bool incomplete = false;  // Something had no value.
        std::string name() const;
        bool remembers() const { return watch->rule().verb == Verb::Stop || watch->rule().verb == Verb::Tell; }
    };

    explicit Watches(std::FILE* to) : to_(to) {}
    static Held::Way held_way(One& one, const Watch::Way& way);
    Changes changes_in(sim::Subdomain& subdomain, bool had_asked);
    Result<void> search(sim::Subdomain& subdomain, const Changes& changes, const std::vector<std::size_t>& which,
                        std::vector<Watch::Found>& found);
    Holders* holders(sim::Subdomain& subdomain);
    void forget_removed(sim::Subdomain& subdomain);
    std::vector<std::string> news(One& one, const Watch::Found& found);
    Result<void> tell(sim::Subdomain& subdomain, std::size_t number, const std::vector<std::string>& lines);
    std::string what_it_says(std::size_t number) const;
    Result<void> agree(sim::Subdomain& subdomain, bool stop, const Result<void>& mine);

    std::FILE* to_;
    std::vector<One> watches_;
    std::vector<Outcome> outcomes_;
    bool any_wrong_ = false;
    bool caught_ = false;                    // There was one already; on all processes.
    std::optional<std::size_t> caught_now_;  // In this tick.
    Witness witness_;                        // Of that, on process 0.
    bool begun_ = false;                     // It has seen the tick before.
    bool asked_ = false;                     // Actions were asked for in that.
    std::uint64_t gone_ = 0;                 // Catoms that there were, until then.
    std::vector<u64> asking_ = {};           // Catoms of this process that asked for actions in it.
    bool in_run_ = false;                    // As part of a run, it follows what changes: the run ends with it.
    std::optional<Holders> holders_;
};

}  // namespace meld::inspect
