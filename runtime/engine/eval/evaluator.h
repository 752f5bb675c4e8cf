// One process's evaluation of a tick: takes the agenda, runs each catom to its local fixpoint on worker threads, then
// commits what neighbours may see. The result does not depend on the number of threads.
#pragma once

#include <array>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "runtime/base/process/parallel_for.h"
#include "runtime/base/process/tick_log.h"
#include "runtime/base/radix_sort.h"
#include "runtime/engine/eval/agenda.h"
#include "runtime/engine/eval/broadcasts.h"
#include "runtime/engine/eval/counts.h"
#include "runtime/engine/eval/failure.h"
#include "runtime/engine/eval/firing.h"
#include "runtime/engine/eval/outbox.h"
#include "runtime/engine/eval/requests.h"
#include "runtime/engine/eval/samples.h"
#include "runtime/engine/eval/timers.h"
#include "runtime/engine/eval/tombstones.h"
#include "runtime/engine/eval/undefined.h"
#include "runtime/engine/tuple/columns.h"
#include "runtime/module/abi/module_abi.h"

namespace meld::eval {

struct Statistics {
    u64 awake = 0;  // Catoms evaluated.
    u64 derivations = 0;
    u64 changes = 0;   // Exported records and rows committed: the traffic of the links.
    u64 messages = 0;  // Linear facts sent.
    u64 dropped = 0;
    u64 far_facts = 0, far_hops = 0;  // Of facts to nodes that no link need lead to, and the messages by which they went.
    bool cut = false;                 // Catoms were skipped, because a signal asked for the end of the run.
};

// An exported column of a catom that has changed, or is about to.
struct Change {
    u32 catom;
    u16 column;
};

// Linear facts that were sent, whichever way they went, with their arguments.
struct Sent {
    std::vector<Message> messages;
    Kept<Value> values;
};

// The position of a catom on the lattice, for `position`.
using Positions = std::function<void(u32 catom, double out[3])>;

class Evaluator {
  public:
    Evaluator(const ModuleInfo& module, tuple::Columns& columns, Workers& workers, Positions positions);
    ~Evaluator();

    // Of the next evaluation.
    Agenda& agenda() { return agendas_[next_agenda_]; }
    const Agenda& agenda() const { return agendas_[next_agenda_]; }
    // Makes room for this many catoms.
    void resize(std::size_t catoms);
    std::size_t bytes() const { return agendas_[0].bytes() + agendas_[1].bytes() + broadcasts_.bytes(); }
    Tombstones& tombstones() { return tombstones_; }
    const Tombstones& tombstones() const { return tombstones_; }
    Undefined& undefined() { return undefined_; }
    const Undefined& undefined() const { return undefined_; }
    Timers& timers() { return timers_; }
    // What groups have lost no longer matters: each is looked at again. For clocks without a bound on how long a catom waits: the timers
    // that are due later than so many ticks from now are those of quarantines.
    template <class Mark, class WakeGroup>
    void end_quarantines(i64 from, const Mark& mark, const WakeGroup& wake_group) {
        tombstones_ = {};
        timers_.fire_late(from, mark, wake_group);
    }
    const Timers& timers() const { return timers_; }
    // Facts and actions that do not come from rules, for the next evaluation.
    Requests& requests() { return requests_; }
    const Requests& requests() const { return requests_; }

    // What catoms read of their neighbours lies apart from these, in mailboxes: a change marks nobody, and facts sent to a mailbox are for
    // the catom that is read there. `acts`: whether a catom is evaluated in this tick; one that is not stays on the agenda. Empty: all are.
    // `before_commit` is called in each evaluation when its changes are known and not yet made: see add_changes(). It may make room for
    // more indices. `reader`: the catom that reads a mailbox, if something may arrive there for one that is not evaluated.
    void read_apart(std::function<void()> before_commit, std::function<bool(u32)> acts, std::function<u32(u32)> reader = {}) {
        apart_ = true;
        before_commit_ = std::move(before_commit);
        acts_ = std::move(acts);
        reader_ = std::move(reader);
    }

    // Called by workers for catoms that had a fact because it was their turn (PredicateInfo::by_turn), and have not used it up.
    using StillActivated = std::function<void(int worker, std::span<const u32> catoms)>;
    void tell_still_activated(StillActivated call) { still_activated_ = std::move(call); }

    // Catoms that are not evaluated any more: what is new to them is dropped. Empty: there are none.
    void leave_out(std::function<bool(u32)> left_out) { left_out_ = std::move(left_out); }

    // For a program that sends facts to nodes that no link need lead to: Host::next_hop, from several threads at once, and whether a fact
    // may go to any node at once.
    void find_ways(std::function<u64(u32 catom, u64 target)> next_hop, bool anywhere) {
        next_hop_ = std::move(next_hop);
        anywhere_ = anywhere;
    }

    // For a program that makes nodes: the number of a catom's n-th one of a tick, from several threads at once.
    void make_nodes(std::function<u64(u32 catom, u32 n)> number) { new_node_ = std::move(number); }

    // A record of a ghost was `before` and has changed: marks those of its neighbours that this concerns.
    void mark_concerned(const Geometry& geometry, u32 catom, u16 column, const u8* before);
    // Where neighbours are read apart: these neighbours of a catom have read `before` of a column until now, and read `after` from now on.
    // Marks those whom this concerns, who are evaluated in this tick or a later one; all of them, unless can_concern().
    void mark_concerned(const SubdomainView& subdomain, const Change& of, const u8* before, const u8* after, std::span<const i32> readers);
    bool can_concern(u16 column) const { return module_.columns[column].concerned != nullptr; }
    // Some record has changed in the last tick, and a neighbour is not looked at again because of it, as it is not concerned. The change
    // has been on its way to that neighbour all the same, and so the run takes another tick.
    bool passed_over() const { return passed_over_; }

    // What catoms tell all their neighbours alike may stay where they write it, for their neighbours to read in the next evaluation, if
    // many are evaluated. Until then, or until it is delivered, nobody looks at facts, and no links change.
    void leave_broadcasts(bool leave) { leave_broadcasts_ = leave; }
    Broadcasts& broadcasts() { return broadcasts_; }

    // Called for every exported change while it is committed, from several threads; `thread` says which. May be empty.
    using OnExport = std::function<void(int thread, u32 catom, u16 column)>;

    // Evaluates the agenda of this tick against `subdomain`, whose geometry and pointers are up to date, and commits. Returns the failure
    // of the catom with the least id, if any failed.
    Failure evaluate(SubdomainView& subdomain, const OnExport& on_export);

    // The messages and actions of the last evaluation, ordered by (receiver, sender, sequence) and by catom id. Linear facts are not among
    // the messages if they were sent as rows.
    const std::vector<Message>& messages() const { return messages_; }
    const std::vector<Action>& actions() const { return actions_; }
    // Those to nodes that may be anywhere, in the same order, by ids.
    const std::vector<FarMessage>& far_messages() const { return far_messages_; }
    // Those to nodes that rules have made in the tick, and the greatest number that one was given, or 0.
    const std::vector<FarMessage>& births() const { return births_; }
    u64 greatest_new_node() const { return greatest_new_node_; }
    // Whether rows of a column were sent, and a call of visit(to, from, const u8* row) for each. The order depends on the threads, but not
    // that of one sender's rows.
    bool sent_rows(u16 column) const;
    template <class Visit>
    void each_sent(u16 column, const Visit& visit) const {
        for (const Outbox* outbox : outboxes_) outbox->each(column, visit);
    }
    template <class Visit>
    void each_sent_entry(u16 column, const Visit& visit) const {
        for (const Outbox* outbox : outboxes_) outbox->each_entry(column, visit);
    }
    // Whether a sent row of the column points to a stored list. The others are in arenas, one a thread, which go with the rows: hands them
    // over in exchange for others, which end.
    bool shares_lists(u16 column) const {
        return std::ranges::any_of(outboxes_, [&](const Outbox* outbox) { return outbox->shares(column); });
    }
    void hand_over_lists(u16 column, std::vector<tuple::Arena>& with);
    // The linear predicates that are stored.
    const std::vector<u16>& linear_predicates() const { return linear_predicates_; }
    // Both together, for whoever looks at a tick: ordered by receiver and sender, and of one sender by predicate.
    Sent all_sent(const Geometry& geometry) const;
    // Calls visit(catom, dirty) for the catoms of the last evaluation, ascending, with why each of them was evaluated.
    template <class Visit>
    void each_evaluated(const Visit& visit) const {
        taken().each(visit);
    }
    // Adds those of them that have changed one of these exported columns, or are about to, in any order; some may come again.
    void add_changed(const std::vector<bool>& columns, std::vector<u32>& catoms) const;
    // The same of all exported columns. Those of a catom follow each other.
    void add_changes(std::vector<Change>& changes) const;
    const Statistics& statistics() const { return statistics_; }
    // What is counted over the run; null: nothing.
    Counts* counts() { return counts_ ? &*counts_ : nullptr; }
    const Counts* counts() const { return counts_ ? &*counts_ : nullptr; }
    // From now on at least the evaluations of each catom are counted.
    void count_evaluations();
    // Where the time goes: the stages go to the log, which lives as long as this. From now on, if the module says where it is, Samples are
    // taken too.
    void measure(TickLog& log);
    // Until now; the evaluator measures no more. Null: the module does not say where it is.
    const CpuSeconds* end_measuring();
    // From now on the firings of these linear rules, by their numbers, are kept until the next evaluation; of none, if it is empty.
    void tell_firings(std::vector<bool> rules);
    // Those of the last evaluation; of each catom in their order.
    std::vector<Firing> firings() const;
    u32 greatest_rank() const { return greatest_rank_; }

    // As if the last evaluation had asked for this, of a run that goes on from a snapshot. Those of one catom come in their order;
    // when all have come they are put in that of the catoms' ids.
    void restore_action(u32 catom, u16 predicate, const Value* arguments);
    void order_actions(const Geometry& geometry);
    // Those of catoms that leave this process.
    void drop_actions(const std::function<bool(u32)>& leaves) {
        std::erase_if(actions_, [&](const Action& action) { return leaves(action.catom); });
    }
    void restore_greatest_rank(u32 rank) { greatest_rank_ = rank; }

  private:
    struct Thread;
    static Thread& of(Eval* e);
    // The agenda of the last evaluation.
    const Agenda& taken() const { return agendas_[1 - next_agenda_]; }
    Agenda& taken() { return agendas_[1 - next_agenda_]; }
    void take_agenda(const Geometry& geometry);
    void evaluate_groups(const SubdomainView& subdomain, Thread& t, int worker, std::span<const u32> groups);
    void evaluate_block(Thread& t, int worker, std::span<const u32> catoms, std::span<const u64> dirty);
    void commit(SubdomainView& subdomain, int thread, const OnExport& on_export);
    bool waits(const Geometry& geometry, u32 catom) const;
    bool asks_concerned(u16 column) const { return concerns_ && !apart_ && module_.columns[column].concerned != nullptr; }
    void mark_concerned(const Geometry& geometry, Thread& t);
    void mark_concerned(Thread& t, std::span<const i32> neighbours, u32 catom, u16 column, const u8* before);
    void gather(const SubdomainView& subdomain);
    // Takes the catoms that are not evaluated in this tick out of the agenda, and puts those that only do not act in it back.
    void leave_out_or_postpone(const Geometry& geometry);
    void order_messages();
    // A catom may lose and gain within one evaluation.
    bool has_linear() const { return !linear_predicates_.empty(); }

    const ModuleInfo& module_;
    tuple::Columns& columns_;
    Workers& workers_;
    Positions positions_;
    Host host_;
    std::array<Agenda, 2> agendas_;  // Of the next evaluation, and of the last one.
    std::size_t next_agenda_ = 0;
    Tombstones tombstones_;
    Undefined undefined_;
    Timers timers_;
    Requests requests_;
    Broadcasts broadcasts_;
    bool leave_broadcasts_ = false;
    bool apart_ = false;
    std::function<bool(u32)> acts_, left_out_;
    std::function<u32(u32)> reader_;
    std::function<void()> before_commit_;
    StillActivated still_activated_;
    std::function<u64(u32, u64)> next_hop_;
    bool anywhere_ = false;
    std::function<u64(u32, u32)> new_node_;
    std::vector<std::unique_ptr<Thread>> threads_;
    std::vector<Outbox*> outboxes_;  // Of the threads.
    std::vector<u16> linear_predicates_;
    std::vector<u32> groups_;                 // Of the agenda that is evaluated, ascending.
    std::vector<std::size_t> groups_before_;  // Of each part of them.
    std::vector<Message> messages_, unsorted_;
    std::vector<Keyed> order_, spare_;
    std::vector<FarMessage> far_messages_, births_;
    u64 greatest_new_node_ = 0;
    std::vector<Action> actions_;
    std::optional<Counts> counts_;
    std::vector<bool> told_;  // By rule.
    TickLog* log_ = nullptr;
    std::optional<Samples> samples_;
    std::optional<Periodic> sampler_;
    Statistics statistics_;
    u32 greatest_rank_ = 0;
    bool concerns_ = false;  // Some column has ColumnInfo::concerned.
    bool passed_over_ = false;
};

}  // namespace meld::eval
