#include "runtime/engine/tuple/facts.h"

#include <algorithm>
#include <array>
#include <cstring>

#include "runtime/base/assert.h"
#include "runtime/base/hash.h"
#include "runtime/engine/tuple/field.h"
#include "runtime/engine/tuple/value_text.h"

namespace meld::tuple {

namespace {

void store(const FieldInfo& field, u8* base, Value v) {
    v = normal(field.type, v);
    // The low bytes come first; a copy of a length known at compile time is one instruction.
    u8* at = base + field.offset;
    switch (field.bytes) {
        case 1:
            *at = static_cast<u8>(v.integer);
            break;
        case 2:
            std::memcpy(at, &v, 2);
            break;
        case 4:
            std::memcpy(at, &v, 4);
            break;
        default:
            std::memcpy(at, &v, 8);
    }
}

void set_present(const PredicateInfo& p, u8* record, bool on) {
    u8& bits = record[p.presence_offset];
    bits = static_cast<u8>(on ? bits | p.presence_mask : bits & ~p.presence_mask);
}

int compare_row(const ModuleInfo& module, const PredicateInfo& p, const u8* row, const Value* arguments) {
    for (u32 i = 0; i < p.arity; ++i)
        if (const int c = compare(type_of(module, p.fields[i]), load_field(p.fields[i], row), arguments[i])) return c;
    return 0;
}

// The first row not less than the arguments, and whether it equals them. Tries the last row first, because facts usually come in order.
std::pair<u32, bool> lower_bound(const ModuleInfo& module, const PredicateInfo& p, const RowsHead& head, const Value* arguments) {
    const u32 size = module.columns[p.column].row_bytes;
    u32 low = 0, high = head.count;
    if (high > 0 && compare_row(module, p, head.data + std::size_t{high - 1} * size, arguments) < 0) return {high, false};
    bool equal = false;
    while (low < high) {
        const u32 middle = low + (high - low) / 2;
        const int c = compare_row(module, p, head.data + std::size_t{middle} * size, arguments);
        equal = equal || c == 0;
        if (c < 0)
            low = middle + 1;
        else
            high = middle;
    }
    return {low, equal};
}

// Sorts facts; equal ones keep their order. A word of the first argument decides most comparisons; facts with the same word are often
// sorted already, because their sender went through its own facts in order.
void sort_facts(const ModuleInfo& module, const PredicateInfo& p, std::vector<const Value*>& facts) {
    constexpr std::size_t kSearched = 16;
    if (facts.size() <= kSearched) {
        for (std::size_t i = 1; i < facts.size(); ++i)
            for (std::size_t k = i; k > 0 && compare_arguments(module, p, facts[k], facts[k - 1]) < 0; --k)
                std::swap(facts[k], facts[k - 1]);
        return;
    }
    struct Prefixed {
        u64 prefix;
        const Value* fact;
    };
    std::vector<Prefixed> all;
    all.reserve(facts.size());
    for (const Value* fact : facts) all.push_back({p.arity == 0 ? 0 : order_prefix(type_of(module, p.fields[0]), fact[0]), fact});
    std::stable_sort(all.begin(), all.end(), [](const Prefixed& a, const Prefixed& b) { return a.prefix < b.prefix; });
    const auto less = [&](const Prefixed& a, const Prefixed& b) { return compare_arguments(module, p, a.fact, b.fact) < 0; };
    for (auto from = all.begin(); from != all.end();) {
        const auto to = std::find_if(from, all.end(), [&](const Prefixed& f) { return f.prefix != from->prefix; });
        if (!std::is_sorted(from, to, less)) std::stable_sort(from, to, less);
        from = to;
    }
    for (std::size_t i = 0; i < all.size(); ++i) facts[i] = all[i].fact;
}

}  // namespace

int compare_arguments(const ModuleInfo& module, const PredicateInfo& p, const Value* a, const Value* b) {
    for (u32 i = 0; i < p.arity; ++i)
        if (const int c = compare(type_of(module, p.fields[i]), a[i], b[i])) return c;
    return 0;
}

u64 hash_arguments(const ModuleInfo& module, const PredicateInfo& p, u64 start, const Value* arguments) {
    for (u32 i = 0; i < p.arity; ++i) start = hash_combine(start, hash(type_of(module, p.fields[i]), arguments[i]));
    return start;
}

std::optional<u32> find_predicate(const ModuleInfo& module, std::string_view name, std::size_t arity) {
    for (u32 i = 0; i < module.predicate_count; ++i)
        if (module.predicates[i].name == name && module.predicates[i].arity == arity && !module.predicates[i].auxiliary) return i;
    return std::nullopt;
}

namespace {

std::optional<u32> find_of_kind(PredicateKind kind, const ModuleInfo& module, std::string_view name, std::size_t arity) {
    const std::optional<u32> found = find_predicate(module, name, arity);
    return found && module.predicates[*found].kind == kind ? found : std::nullopt;
}

}  // namespace

std::optional<u32> find_action(const ModuleInfo& module, std::string_view name, std::size_t arity) {
    return find_of_kind(PredicateKind::Action, module, name, arity);
}
std::optional<u32> find_sensed(const ModuleInfo& module, std::string_view name, std::size_t arity) {
    return find_of_kind(PredicateKind::Sensed, module, name, arity);
}

namespace {

u32 rank_at(const PredicateInfo& p, const u8* at) { return p.rank_offset == kNone32 ? kAbsent : word_at(at, p.rank_offset); }

// `values` is room for the arguments. Returns false if the visit has.
template <class Visit>
bool facts_at(const ModuleInfo& module, const Columns& columns, const Geometry& geometry, const PredicateInfo& p, u32 catom,
              std::vector<Value>& values, const Visit& visit) {
    if (p.storage == Storage::Rows) {
        const RowsHead& head = columns.rows(p.column, catom);
        for (u32 r = 0; r < head.count; ++r) {
            const u8* const row = head.data + std::size_t{r} * module.columns[p.column].row_bytes;
            read_row(p, row, values);
            if (!visit(values.data(), rank_at(p, row))) return false;
        }
        return true;
    }
    const u8* record = columns.entry(p.column, catom);
    if (p.storage == Storage::PerLink) {
        const u32 ports = word_at(record, p.presence_offset);
        for (i32 port = 0; port < geometry.ports; ++port) {
            const i32 other = neighbour_at(geometry, catom, port);
            if ((ports >> port & 1) == 0 || other < 0) continue;
            values[0].catom = id_of(geometry, static_cast<u32>(other));
            for (u32 i = 1; i < p.arity; ++i) values[i] = load_field(p.fields[i], record, static_cast<std::size_t>(port));
            if (!visit(values.data(), kAbsent)) return false;
        }
        return true;
    }
    if (!is_present(p, record)) return true;
    for (u32 i = 0; i < p.arity; ++i) values[i] = load_field(p.fields[i], record);
    return visit(values.data(), rank_at(p, record));
}

}  // namespace

void each_fact(const ModuleInfo& module, const Columns& columns, const Geometry& geometry, u32 predicate, u32 catom,
               const std::function<void(const Value*)>& visit) {
    each_fact_of(module, columns, geometry, predicate, {&catom, 1}, [&](u32, const Value* values) { visit(values); });
}

void each_fact_of(const ModuleInfo& module, const Columns& columns, const Geometry& geometry, u32 predicate, std::span<const u32> catoms,
                  const std::function<void(u32, const Value*)>& visit) {
    const PredicateInfo& p = module.predicates[predicate];
    if (p.column == kNone16) return;
    std::vector<Value> values(p.arity);
    for (const u32 catom : catoms)
        facts_at(module, columns, geometry, p, catom, values, [&](const Value* arguments, u32) {
            visit(catom, arguments);
            return true;
        });
}

bool each_ranked_fact(const ModuleInfo& module, const Columns& columns, const Geometry& geometry, u32 predicate, u32 catom,
                      std::vector<Value>& room, const std::function<bool(const Value*, u32)>& visit) {
    const PredicateInfo& p = module.predicates[predicate];
    if (p.column == kNone16) return true;
    room.resize(p.arity);
    return facts_at(module, columns, geometry, p, catom, room, visit);
}

u32 count_facts(const ModuleInfo& module, const Columns& columns, const Geometry& geometry, u32 predicate, u32 catom) {
    const PredicateInfo& p = module.predicates[predicate];
    if (p.column == kNone16) return 0;
    if (p.storage == Storage::Rows) return columns.rows(p.column, catom).count;
    const u8* record = columns.entry(p.column, catom);
    if (p.storage != Storage::PerLink) return is_present(p, record) ? 1 : 0;
    const u32 ports = word_at(record, p.presence_offset);
    u32 count = 0;
    for (i32 port = 0; port < geometry.ports; ++port) count += (ports >> port & 1) != 0 && neighbour_at(geometry, catom, port) >= 0;
    return count;
}

bool give_fact(const ModuleInfo& module, Columns& columns, u32 predicate, u32 catom, const Value* arguments, int pool) {
    const PredicateInfo& p = module.predicates[predicate];
    MELD_EXPECT(p.column != kNone16);
    const ColumnInfo& c = module.columns[p.column];
    if (p.storage != Storage::Rows) {
        bool same = is_present(p, columns.entry(p.column, catom));
        columns.change_record(p.column, catom, pool, [&](u8* record) {
            for (u32 i = 0; i < p.arity; ++i) {
                same = same && compare(type_of(module, p.fields[i]), load_field(p.fields[i], record), arguments[i]) == 0;
                store(p.fields[i], record, arguments[i]);
            }
            set_present(p, record, true);
        });
        columns.release_dropped(pool);
        return !same;
    }
    const RowsHead& head = columns.rows(p.column, catom);
    // The most frequent case by far of facts without arguments: there is nothing to be searched or compared.
    if (p.arity == 0 && head.count == 0 && c.row_bytes == 1) {
        const u8 unit = 0;
        columns.set_rows(p.column, catom, &unit, 1, pool);
        columns.note_added(p.column, catom, &unit, pool);
        return true;
    }
    const auto [at, equal] = lower_bound(module, p, head, arguments);
    if (equal && p.kind != PredicateKind::Linear) return false;
    std::array<u8, 256> small;
    std::vector<u8> large(c.row_bytes > small.size() ? c.row_bytes : 0);
    u8* row = large.empty() ? small.data() : large.data();
    std::memset(row, 0, c.row_bytes);
    for (u32 i = 0; i < p.arity; ++i) store(p.fields[i], row, arguments[i]);
    columns.insert_row(p.column, catom, at, row, pool);
    columns.note_added(p.column, catom, row, pool);
    return true;
}

bool give_facts(const ModuleInfo& module, Columns& columns, u32 predicate, u32 catom, std::vector<const Value*>& facts,
                std::vector<u8>& rows, int pool) {
    const PredicateInfo& p = module.predicates[predicate];
    const u32 size = module.columns[p.column].row_bytes;
    const RowsHead& head = columns.rows(p.column, catom);
    sort_facts(module, p, facts);
    rows.clear();
    u32 held = 0, added = 0;
    const auto keep_held = [&] {
        rows.insert(rows.end(), head.data + std::size_t{held} * size, head.data + (std::size_t{held} + 1) * size), ++held;
    };
    const Value* before = nullptr;
    for (const Value* arguments : facts) {
        int c = -1;
        while (held < head.count && (c = compare_row(module, p, head.data + std::size_t{held} * size, arguments)) < 0) keep_held();
        if (p.kind != PredicateKind::Linear) {
            const bool known = (held < head.count && c == 0) || (before != nullptr && compare_arguments(module, p, before, arguments) == 0);
            if (known) continue;
        }
        rows.resize(rows.size() + size, 0);
        u8* row = rows.data() + rows.size() - size;
        for (u32 i = 0; i < p.arity; ++i) store(p.fields[i], row, arguments[i]);
        before = arguments;
        ++added;
    }
    if (added == 0) return false;
    while (held < head.count) keep_held();
    columns.replace_rows(p.column, catom, rows.data(), static_cast<u32>(rows.size() / size), pool);
    columns.release_dropped(pool);
    return true;
}

bool take_fact(const ModuleInfo& module, Columns& columns, u32 predicate, u32 catom, const Value* arguments, int pool) {
    const PredicateInfo& p = module.predicates[predicate];
    const ColumnInfo& c = module.columns[p.column];
    if (p.storage != Storage::Rows) {
        const u8* held = columns.entry(p.column, catom);
        if (!is_present(p, held)) return false;
        for (u32 i = 0; i < p.arity; ++i)
            if (compare(type_of(module, p.fields[i]), load_field(p.fields[i], held), arguments[i]) != 0) return false;
        columns.change_record(p.column, catom, pool, [&](u8* record) {
            for (u32 i = 0; i < p.arity; ++i) store(p.fields[i], record, Value{});
            set_present(p, record, false);
        });
        columns.release_dropped(pool);
        return true;
    }
    const RowsHead& head = columns.rows(p.column, catom);
    const auto [at, equal] = lower_bound(module, p, head, arguments);
    if (!equal) return false;
    std::vector<u8> rows(std::size_t{head.count} * c.row_bytes);
    std::memcpy(rows.data(), head.data, rows.size());
    const std::size_t before = std::size_t{at} * c.row_bytes;
    std::memmove(rows.data() + before, rows.data() + before + c.row_bytes, rows.size() - before - c.row_bytes);
    columns.replace_rows(p.column, catom, rows.data(), head.count - 1, pool);
    columns.release_dropped(pool);
    return true;
}

Numbers read_numbers(const ModuleInfo& module, const Columns& columns, u32 predicate, u32 catom) {
    const PredicateInfo& p = module.predicates[predicate];
    const u8* record = columns.entry(p.column, catom);
    Numbers numbers;
    if (!is_present(p, record)) return numbers;
    if (p.fields[0].type == ValueType::Vec3) {
        const List* vector = load_field(p.fields[0], record).list;
        for (; numbers.count < 3; ++numbers.count) numbers.at[numbers.count] = item(vector, numbers.count).real;
    } else {
        for (; numbers.count < p.arity; ++numbers.count) numbers.at[numbers.count] = load_field(p.fields[numbers.count], record).real;
    }
    return numbers;
}

void give_numbers(const ModuleInfo& module, Columns& columns, u32 predicate, u32 catom, const Numbers& numbers, int pool) {
    const PredicateInfo& p = module.predicates[predicate];
    MELD_EXPECT(p.storage == Storage::Single && numbers.count <= numbers.at.size());
    u8* record = columns.entry(p.column, catom);
    std::array<u64, 4> words{};
    for (std::size_t i = 0; i < numbers.count; ++i) words[i] = normal(ValueType::Float, Value{.real = numbers.at[i]}).catom;
    if (p.fields[0].type != ValueType::Vec3) {
        // No list of the record changes, so no owner does.
        for (u32 i = 0; i < p.arity; ++i) store(p.fields[i], record, Value{.catom = words[i]});
        set_present(p, record, true);
    } else if (u64* items = is_present(p, record) ? columns.lists().own_items(load_field(p.fields[0], record).list) : nullptr;
               items != nullptr) {
        std::copy_n(words.begin(), 3, items);
    } else {
        const List list{words.data(), 3, 0};
        const Value vector{.list = &list};
        give_fact(module, columns, predicate, catom, &vector, pool);
    }
}

std::string print_fact(const ModuleInfo& module, const PredicateInfo& p, u64 id, const Value* arguments) {
    std::string text = std::string(p.name) + "(@" + std::to_string(id);
    for (u32 i = 0; i < p.arity; ++i) text += ", " + print_value(type_of(module, p.fields[i]), arguments[i]);
    return text + ")";
}

}  // namespace meld::tuple
