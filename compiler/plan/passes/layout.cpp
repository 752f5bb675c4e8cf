// Pass: layout. Chooses for every predicate the smallest storage that its declaration and rules allow, puts fields that are updated
// together into one record, and gives every column its dirty bits. Assumes localized rules and strata.
#include <algorithm>
#include <bit>
#include <map>
#include <set>

#include "compiler/plan/plan.h"

namespace meld::plan {

using namespace check;

namespace {

// The low bits of a dirty word are the runtime's own.
constexpr std::uint32_t kFirstBit = std::countr_zero(std::uint64_t{kFirstModuleBit});
constexpr std::uint32_t kBits = kDirtyWordBits - kFirstBit;
constexpr std::uint32_t kPorts = kMaxPorts;

struct Facts {  // The properties of a predicate that follow from the rules.
    bool used = false;
    bool exported = false;
    bool derived = false;  // By a view.
    bool ranked = false;
    bool recursive = false;
    bool per_link = true;  // Every derivation names a direct neighbour as the second argument.
    std::size_t stratum = 0;
};

class Layout {
  public:
    explicit Layout(Plan& plan) : plan_(plan), program_(plan.program), facts_(program_.predicates.count()) {}

    void run() {
        MELD_EXPECT(plan_.columns.empty() && plan_.stored.empty(), "laid out twice");
        study_rules();
        study_components();
        plan_.stored.resize(program_.predicates.count());
        for (const PredicateId p : program_.predicates.ids()) choose(p);
        make_columns();
        number_bits();
    }

  private:
    Facts& of(PredicateId p) { return facts_[p.index()]; }

    void study_rules() {
        // C++ modules may request an action that the program declares, even if no rule does.
        for (const PredicateId id : program_.predicates.ids()) {
            const Predicate& p = program_.predicates[id];
            of(id).used = (!p.prelude || (p.repeated && p.kind == PredicateKind::Action)) && !p.auxiliary;
        }
        for (const Rule& rule : program_.rules) {
            const auto read = [&](const Atom& a, bool) {
                of(a.predicate).used = true;
                if (a.arguments[0].variable != rule.site) of(a.predicate).exported = true;
            };
            each_atom(rule.body, read);
            each_head(rule.heads, [&](const Head& h) {
                if (h.kind == Head::Kind::Fact) of(h.atom.predicate).used = true;
                each_atom(h.body, read);
            });
            if (rule.linear) continue;
            const Atom& head = rule.heads[0].atom;
            of(head.predicate).derived = true;
            of(head.predicate).per_link = of(head.predicate).per_link && names_neighbour(rule, head);
        }
    }
    // The second argument is a variable that some positive link joins to the execution site.
    bool names_neighbour(const Rule& rule, const Atom& head) const {
        if (head.arguments.size() < 2 || !head.arguments[1].is_variable()) return false;
        const VariableId v = head.arguments[1].variable;
        for (const Clause& c : rule.body) {
            if (c.kind != Clause::Kind::Atom || !program_.predicates[c.atom.predicate].route || c.atom.arguments.size() < 2 ||
                !c.atom.arguments[1].is_variable())
                continue;
            const VariableId a = c.atom.arguments[0].variable, b = c.atom.arguments[1].variable;
            // A stored route at the execution site may point to a catom that has left; a fact of `neighbor`, or one that the other
            // catom exports, may not.
            const bool surely = program_.predicates[c.atom.predicate].world != WorldSource::None || b == rule.site;
            if (surely && ((a == rule.site && b == v) || (b == rule.site && a == v))) return true;
        }
        return false;
    }

    void study_components() {
        for (std::size_t i = 0; i < program_.strata.size(); ++i) {
            const check::Stratum& c = program_.strata[i];
            const bool ranked = has_ranks(program_, c);
            for (const PredicateId p : c.predicates) {
                of(p).stratum = i;
                of(p).recursive = c.recursive;
                of(p).ranked = ranked;
            }
        }
    }

    void choose(PredicateId id) {
        const Predicate& p = program_.predicates[id];
        const Facts& f = of(id);
        Stored& s = plan_.stored[id.index()];
        s.used = f.used;
        if (!f.used) return;
        if (p.world != WorldSource::None) {
            s.storage = Storage::World;
            return;
        }
        if (p.kind == PredicateKind::Action && !f.derived) return;  // Only linear rules act: nothing is stored.
        s.exported = f.exported;
        s.ranked = f.ranked;
        s.waits = p.complete_link.valid();
        const std::size_t arity = p.arguments.size() - 1;
        // How long something has held is of a neighbour, not of a port.
        const bool keyed_by_link = p.aggregate == Aggregate::None ? arity == 1 : p.aggregate_at == 2 && p.aggregate != Aggregate::Since;
        if (p.linear())
            s.storage = Storage::Rows;
        else if (arity == 0)
            s.storage = Storage::Flag;
        else if (p.aggregate != Aggregate::None && p.aggregate_at == 1)
            s.storage = Storage::Single;
        else if (!program_.by_links && f.derived && f.per_link && keyed_by_link && p.arguments[1].type == Type::Node && !f.exported &&
                 !f.recursive && p.kind == PredicateKind::Persistent)
            s.storage = Storage::PerLink;
        else
            s.storage = Storage::Rows;
        for (std::size_t i = 1; i < p.arguments.size(); ++i) s.fields.push_back({p.arguments[i].type, bytes_of(p.arguments[i]), 0});
        if (p.given.valid())
            s.base = p.given;
        else if (p.kind != PredicateKind::Action && !f.derived)
            s.base = id;
    }

    static std::uint32_t bytes_of(const Argument& a) {
        if (a.type == Type::Bool) return 1;
        if (a.type != Type::Int) return 8;
        for (const std::uint32_t bytes : {1u, 2u, 4u})
            if (const std::int64_t half = std::int64_t{1} << (8 * bytes - 1); a.least >= -half && a.greatest < half) return bytes;
        return 8;
    }

    // ---- columns

    // Records: the predicates of one stratum that are alike in being exported; given flags and values share one.
    std::string record_group(PredicateId id) {
        const Stored& s = plan_.of(id);
        const std::string side = s.exported ? "exported" : "private";
        if (!of(id).derived) return "given-" + side;
        if (!s.exported && !s.ranked) return "derived-private";
        return fmt::format("{}-{}", side, of(id).stratum);
    }

    void make_columns() {
        std::vector<std::string> order;
        std::map<std::string, std::vector<PredicateId>> groups;
        for (const PredicateId id : program_.predicates.ids()) {
            const Storage storage = plan_.of(id).storage;
            if (storage == Storage::Unused || storage == Storage::World) continue;
            if (storage == Storage::Rows) {
                rows_column(id);
                continue;
            }
            const std::string group = record_group(id);
            if (!groups.contains(group)) order.push_back(group);
            groups[group].push_back(id);
        }
        for (const std::string& group : order) record_column(groups[group]);
    }

    struct Item {
        std::uint32_t bytes;
        std::uint32_t count;  // PerLink: one for each port.
        std::uint32_t* offset;
    };
    // Largest first, in order of declaration among equals: no padding but at the end.
    static std::uint32_t place(std::vector<Item>& items) {
        std::stable_sort(items.begin(), items.end(), [](const Item& a, const Item& b) { return a.bytes > b.bytes; });
        std::uint32_t at = 0, align = 1;
        for (Item& item : items) {
            MELD_EXPECT(std::has_single_bit(item.bytes) && item.count > 0, "a field of {} bytes", item.bytes);
            *item.offset = at;
            at += item.bytes * item.count;
            align = std::max(align, item.bytes);
        }
        return (at + align - 1) / align * align;
    }

    // The fields of these predicates and what else stands with them. Ints are narrow only where all together become smaller.
    std::uint32_t place_fields(const std::vector<PredicateId>& predicates, const std::vector<Item>& others) {
        const auto all = [&] {
            std::vector<Item> items;
            for (const PredicateId id : predicates) {
                Stored& s = plan_.stored[id.index()];
                const bool per_link = s.storage == Storage::PerLink;
                for (std::size_t i = per_link ? 1 : 0; i < s.fields.size(); ++i)
                    items.push_back({s.fields[i].bytes, per_link ? kPorts : 1, &s.fields[i].offset});
            }
            items.insert(items.end(), others.begin(), others.end());
            return place(items);
        };
        const std::uint32_t narrow = all();
        std::vector<std::uint32_t> widths;
        each_int(predicates, [&](Field& f) {
            widths.push_back(f.bytes);
            f.bytes = 8;
        });
        const std::uint32_t wide = all();
        if (narrow >= wide) return wide;
        std::size_t i = 0;
        each_int(predicates, [&](Field& f) { f.bytes = widths[i++]; });
        return all();
    }
    template <class Visit>
    void each_int(const std::vector<PredicateId>& predicates, const Visit& visit) {
        for (const PredicateId id : predicates)
            for (Field& f : plan_.stored[id.index()].fields)
                if (f.type == Type::Int) visit(f);
    }

    void rows_column(PredicateId id) {
        Stored& s = plan_.stored[id.index()];
        std::vector<Item> others;
        if (s.ranked) others.push_back({kRankBytes, 1, &s.rank_offset});
        if (s.waits) others.push_back({kWaitedPortsBytes, 1, &s.from_offset});
        Column c;
        c.name = program_.predicates[id].name;
        c.rows = true;
        c.exported = s.exported;
        c.predicates = {id};
        c.stride = kRowsHeadBytes;
        c.row_bytes = std::max<std::uint32_t>(1, place_fields({id}, others));
        s.column = plan_.columns.add(std::move(c));
    }

    void record_column(const std::vector<PredicateId>& predicates) {
        Column c;
        c.predicates = predicates;
        std::vector<Item> others;
        std::vector<std::uint32_t> bytes;  // Bytes of kPresenceBits predicates each.
        bytes.reserve(predicates.size());
        std::uint32_t bit = kPresenceBits;
        std::vector<std::pair<PredicateId, std::size_t>> byte_of;
        for (const PredicateId id : predicates) {
            Stored& s = plan_.stored[id.index()];
            const bool per_link = s.storage == Storage::PerLink;
            c.name += (c.name.empty() ? "" : "+") + program_.predicates[id].name;
            c.exported = s.exported;
            if (s.ranked) {
                others.push_back({kRankBytes, 1, &s.rank_offset});
            } else if (per_link) {
                others.push_back({kPortMaskBytes, 1, &s.presence_offset});
            } else {
                if (bit == kPresenceBits) {
                    bytes.push_back(0);
                    others.push_back({kPresenceBytes, 1, &bytes.back()});
                    bit = 0;
                }
                byte_of.push_back({id, bytes.size() - 1});
                s.presence_mask = 1u << bit++;
            }
        }
        c.stride = place_fields(predicates, others);
        for (const auto& [id, byte] : byte_of) plan_.stored[id.index()].presence_offset = bytes[byte];
        const ColumnId column = plan_.columns.add(std::move(c));
        for (const PredicateId id : predicates) plan_.stored[id.index()].column = column;
    }

    // If there are more columns than bits, columns share bits: they are evaluated more often, never too seldom.
    void number_bits() {
        std::uint32_t next = 0;
        const std::uint32_t bits = activated_fact(plan_) ? kBits - 1 : kBits;  // The highest one is kDirtyTurn.
        const auto bit = [&] { return std::uint64_t{1} << (kFirstBit + next++ % bits); };
        for (Column& c : plan_.columns) {
            c.own_dirty = bit();
            if (c.exported) c.reader_dirty = bit();
        }
    }

    Plan& plan_;
    Program& program_;
    std::vector<Facts> facts_;
};

}  // namespace

void lay_out(Plan& plan) { Layout(plan).run(); }

bool has_ranks(const Program& program, const check::Stratum& stratum) {
    const bool aggregates = std::ranges::any_of(stratum.predicates, [&](PredicateId p) {
        const Predicate& member = program.predicates[p];
        return member.aggregate != Aggregate::None || member.front != Aggregate::None;
    });
    return stratum.recursive && !stratum.tree && (stratum.links || aggregates);
}

std::optional<PredicateId> activated_fact(const Plan& plan) {
    if (!plan.program.by_links) return std::nullopt;
    for (const PredicateId id : plan.program.predicates.ids()) {
        const Predicate& p = plan.program.predicates[id];
        if (p.linear() && p.name == "activated" && p.arguments.size() == 1 && plan.of(id).storage == Storage::Rows) return id;
    }
    return std::nullopt;
}

std::uint64_t bytes_per_catom(const Plan& plan) {
    std::uint64_t bytes = 0;
    for (const Column& c : plan.columns) bytes += c.stride;
    return bytes;
}

}  // namespace meld::plan
