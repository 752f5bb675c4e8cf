#include "runtime/results/record/recorded_predicate.h"

#include <algorithm>
#include <bit>
#include <limits>
#include <nlohmann/json.hpp>
#include <utility>

#include "runtime/base/assert.h"
#include "runtime/engine/tuple/facts.h"
#include "runtime/engine/tuple/single_facts.h"
#include "runtime/engine/tuple/value_text.h"
#include "runtime/results/facts/fact_tables.h"

namespace meld::record {

RecordedPredicate::RecordedPredicate(const ModuleInfo& module, u32 predicate, std::string name)
    : predicate_(predicate), name_(std::move(name)) {
    const PredicateInfo& p = module.predicates[predicate];
    several_ = p.arity > 0 && (p.storage == Storage::Rows || p.storage == Storage::PerLink);
    simple_ = tuple::SingleFacts::fits(p) || (p.arity == 0 && p.storage == Storage::Rows);
    for (u16 i = 0; i < p.arity; ++i) {
        Argument argument{.name = argument_name(p, i), .array = name_, .type = tuple::type_name(tuple::type_of(module, p.fields[i]))};
        if (i > 0) argument.array += "." + argument.name;
        const ValueType type = p.fields[i].type;
        if (type == ValueType::Float || type == ValueType::Vec3)
            argument.stored = RecordedArray::Float64;
        else if (type >= ValueType::String)
            argument.stored = RecordedArray::Text;
        if (type == ValueType::Vec3) argument.components = 3;
        arguments_.push_back(std::move(argument));
    }
}

std::string RecordedPredicate::description() const {
    nlohmann::ordered_json arguments = nlohmann::ordered_json::array();
    for (const Argument& argument : arguments_)
        arguments.push_back({{"name", argument.name}, {"type", argument.type}, {"array", argument.array}});
    return nlohmann::ordered_json{{"name", name_}, {"table", several_}, {"arguments", std::move(arguments)}}.dump();
}

void RecordedPredicate::pack_fact(const ModuleInfo& module, const Value* fact, ByteWriter& out) const {
    const PredicateInfo& p = module.predicates[predicate_];
    for (std::size_t i = 0; i < arguments_.size(); ++i) {
        const tuple::Type type = tuple::type_of(module, p.fields[i]);
        if (arguments_[i].stored == RecordedArray::Text)
            out.write_string(tuple::print_value(type, fact[i]));
        else if (type.kind() == ValueType::Vec3)
            for (std::size_t k = 0; k < 3; ++k) out.write(tuple::item(fact[i].list, k).real);
        else
            out.write(fact[i]);
    }
}

// How many facts there are; the first one, as it is stored; all of them, in the order of their arguments.
void RecordedPredicate::pack(sim::Subdomain& subdomain, sim::Catom catom, ByteWriter& out) const {
    const PredicateInfo& p = subdomain.module.predicates[predicate_];
    if (p.storage == Storage::Rows && subdomain.columns.rows(p.column, catom).count == 0) return out.write_count(0);
    std::vector<std::vector<Value>> facts;
    tuple::each_fact(subdomain.module, subdomain.columns, subdomain.geometry(), predicate_, catom,
                     [&](const Value* v) { facts.emplace_back(v, v + p.arity); });
    out.write_count(facts.size());
    if (facts.empty() || arguments_.empty()) return;
    pack_fact(subdomain.module, facts[0].data(), out);
    if (!several_) return;
    std::sort(facts.begin(), facts.end(),
              [&](const auto& a, const auto& b) { return tuple::compare_arguments(subdomain.module, p, a.data(), b.data()) < 0; });
    for (const auto& fact : facts) pack_fact(subdomain.module, fact.data(), out);
}

void RecordedPredicate::skip(ByteReader& in) const {
    const auto count = in.read<std::uint32_t>();
    if (count == 0 || arguments_.empty()) return;
    for (std::uint32_t fact = 0; fact < (several_ ? count + 1 : 1); ++fact)
        for (const Argument& argument : arguments_) {
            if (argument.stored == RecordedArray::Text)
                in.read_block();
            else
                in.read_bytes(static_cast<std::size_t>(argument.components) * sizeof(u64));
        }
}

void RecordedPredicate::begin_step(std::size_t rows) {
    counts_.clear();
    counts_.reserve(rows);
    catoms_.clear();
    updated_ = counts_same_ = table_same_ = false;
    for (Argument& argument : arguments_)
        for (Cells* cells : {&argument.first, &argument.all}) {
            cells->clear();
            cells->same = false;
        }
    for (Argument& argument : arguments_)
        if (argument.stored != RecordedArray::Text) argument.first.words.reserve(rows * static_cast<std::size_t>(argument.components));
}

void RecordedPredicate::take(const Argument& argument, ByteReader& in, Cells& cells) {
    if (argument.stored == RecordedArray::Text) return cells.texts.push_back(in.read_string());
    for (int k = 0; k < argument.components; ++k) cells.words.push_back(in.read<u64>());
}

// Where there is no fact a number is -1, a vector is not a number, a text is empty.
void RecordedPredicate::take_first(const Argument& argument, std::uint32_t count, ByteReader& in, Cells& cells) {
    if (count > 0)
        take(argument, in, cells);
    else if (argument.stored == RecordedArray::Text)
        cells.texts.emplace_back();
    else if (argument.components == 3)
        cells.words.insert(cells.words.end(), 3, std::bit_cast<u64>(std::numeric_limits<double>::quiet_NaN()));
    else
        cells.words.push_back(nothing(argument));
}

u64 RecordedPredicate::nothing(const Argument& argument) {
    return argument.stored == RecordedArray::Float64 ? std::bit_cast<u64>(-1.0) : ~u64{0};
}

void RecordedPredicate::unpack(u64 id, ByteReader& in) {
    const auto count = in.read<std::uint32_t>();
    counts_.push_back(count);
    for (Argument& argument : arguments_) take_first(argument, count, in, argument.first);
    if (!several_) return;
    for (std::uint32_t fact = 0; fact < count; ++fact) {
        catoms_.push_back(id);
        for (Argument& argument : arguments_) take(argument, in, argument.all);
    }
}

template <class Visit>
void RecordedPredicate::with_count_of(const sim::Subdomain& subdomain, const Visit& visit) const {
    const PredicateInfo& p = subdomain.module.predicates[predicate_];
    if (p.storage == Storage::Rows) return visit([&](sim::Catom c) { return subdomain.columns.rows(p.column, c).count; });
    const tuple::SingleFacts facts(subdomain.module, subdomain.columns, predicate_);
    visit([&](sim::Catom c) { return facts.find(c) != nullptr ? u32{1} : u32{0}; });
}

template <class Visit>
void RecordedPredicate::each_argument(const sim::Subdomain& subdomain, const Visit& visit) {
    const tuple::SingleFacts facts(subdomain.module, subdomain.columns, predicate_);
    for (u32 i = 0; i < arguments_.size(); ++i)
        visit(arguments_[i], [&facts, i, nothing = nothing(arguments_[i])](sim::Catom c) {
            const u8* const fact = facts.find(c);
            return fact != nullptr ? facts.argument(fact, i).catom : nothing;
        });
}

void RecordedPredicate::read(sim::Subdomain& subdomain, std::span<const sim::Catom> catoms) {
    begin_step(catoms.size());
    if (simple_) {
        with_count_of(subdomain, [&](const auto& count_of) {
            for (const sim::Catom c : catoms) counts_.push_back(count_of(c));
        });
        each_argument(subdomain, [&](Argument& argument, const auto& word_of) {
            for (const sim::Catom c : catoms) argument.first.words.push_back(word_of(c));
        });
        return;
    }
    ByteWriter packed;
    for (const sim::Catom c : catoms) {
        liveness::beat();
        packed.clear();
        pack(subdomain, c, packed);
        ByteReader facts(packed.view(), "a row of a recording");
        unpack(subdomain.ensemble.id(c), facts);
    }
}

void RecordedPredicate::begin_update() {
    updated_ = counts_same_ = table_same_ = true;
    changed_counts_.clear();
    for (Argument& argument : arguments_) argument.first.same = argument.all.same = true;
    for (Argument& argument : arguments_) argument.first.changed.clear();
    MELD_EXPECT(fresh_.empty(), "{} catoms are left of an update", fresh_.size());
}

// Puts what is in `room` into a row.
void RecordedPredicate::Argument::put(std::size_t row) {
    const auto replace = [&](auto& column, auto& with) {
        const auto at = column.begin() + static_cast<std::ptrdiff_t>(row * with.size());
        if (with.empty() || std::equal(with.begin(), with.end(), at)) return;
        std::move(with.begin(), with.end(), at);
        first.same = false;
        first.changed.push_back(row);
    };
    replace(first.words, room.words);
    replace(first.texts, room.texts);
    room.clear();
}

void RecordedPredicate::set_count(std::size_t row, u64 count) {
    if (std::exchange(counts_[row], count) == count) return;
    changed_counts_.push_back(row);
    counts_same_ = false;
}

void RecordedPredicate::update(sim::Subdomain& subdomain, const RowsOfCatoms& rows) {
    if (simple_) {
        with_count_of(subdomain,
                      [&](const auto& count_of) { rows.each([&](u32 row, sim::Catom catom) { set_count(row, count_of(catom)); }); });
        each_argument(subdomain, [&](Argument& argument, const auto& word_of) {
            Cells& cells = argument.first;
            rows.each([&](u32 row, sim::Catom catom) {
                const u64 word = word_of(catom);
                if (std::exchange(cells.words[row], word) != word) cells.changed.push_back(row);
            });
            cells.same = cells.changed.empty();
        });
        return;
    }
    ByteWriter packed;
    rows.each([&](u32 row, sim::Catom catom) {
        packed.clear();
        pack(subdomain, catom, packed);
        ByteReader facts(packed.view(), "a row of a recording");
        update(row, subdomain.ensemble.id(catom), facts);
    });
}

void RecordedPredicate::update(std::size_t row, u64 id, ByteReader& in) {
    const auto count = in.read<std::uint32_t>();
    const u64 before = counts_[row];
    set_count(row, count);
    for (Argument& argument : arguments_) {
        take_first(argument, count, in, argument.room);
        argument.put(row);
    }
    if (!several_ || (before == 0 && count == 0)) return;
    fresh_.push_back({id, count});
    for (std::uint32_t fact = 0; fact < count; ++fact)
        for (Argument& argument : arguments_) take(argument, in, argument.fresh);
}

// Appends rows to the facts of all catoms.
void RecordedPredicate::Argument::append(const Cells& from, std::size_t first_row, std::size_t rows) {
    const auto add = [&](auto& to, const auto& values, std::size_t width) {
        const auto begin = values.begin() + static_cast<std::ptrdiff_t>(first_row * width);
        to.insert(to.end(), begin, begin + static_cast<std::ptrdiff_t>(rows * width));
    };
    if (stored == RecordedArray::Text)
        add(all.texts, from.texts, 1);
    else
        add(all.words, from.words, static_cast<std::size_t>(components));
}

// The table is merged with what has changed. Cost: its facts, or nothing if no catom has others.
void RecordedPredicate::end_update() {
    if (fresh_.empty()) return;
    const std::vector<u64> before = std::exchange(catoms_, {});
    std::vector<Cells> cells_before;
    for (Argument& argument : arguments_) cells_before.push_back(std::exchange(argument.all, {}));
    std::size_t at = 0, next = 0;
    const auto keep_until = [&](std::size_t end) {
        catoms_.insert(catoms_.end(), before.begin() + static_cast<std::ptrdiff_t>(at), before.begin() + static_cast<std::ptrdiff_t>(end));
        for (std::size_t i = 0; i < arguments_.size(); ++i) arguments_[i].append(cells_before[i], at, end - at);
    };
    for (const Fresh& one : fresh_) {
        const auto [from, to] = std::equal_range(before.begin() + static_cast<std::ptrdiff_t>(at), before.end(), one.id);
        keep_until(static_cast<std::size_t>(from - before.begin()));
        at = static_cast<std::size_t>(to - before.begin());
        catoms_.insert(catoms_.end(), one.count, one.id);
        for (Argument& argument : arguments_) argument.append(argument.fresh, next, one.count);
        next += one.count;
    }
    keep_until(before.size());
    table_same_ = catoms_ == before;
    for (std::size_t i = 0; i < arguments_.size(); ++i) {
        table_same_ = table_same_ && arguments_[i].all == cells_before[i];
        arguments_[i].fresh.clear();
    }
    fresh_.clear();
}

RecordedArray RecordedPredicate::Argument::cells(const std::string& shown, const Cells& cells, bool updated) const {
    const bool texts = stored == RecordedArray::Text;
    return {.name = shown,
            .type = stored,
            .data = texts ? static_cast<const void*>(cells.texts.data()) : cells.words.data(),
            .components = components,
            .texts = array,
            .same = cells.same,
            .changed = updated ? &cells.changed : nullptr};
}

void RecordedPredicate::list(std::vector<RecordedArray>& arrays, std::vector<RecordedTable>& tables) const {
    // Without arguments the number of facts is all there is to say: 1 or 0.
    const std::string counts = arguments_.empty() ? name_ : name_ + "." + kFactsColumn;
    for (const Argument& argument : arguments_) arrays.push_back(argument.cells(argument.array, argument.first, updated_));
    arrays.push_back({.name = counts, .data = counts_.data(), .same = counts_same_, .changed = updated_ ? &changed_counts_ : nullptr});
    if (!several_) return;
    RecordedTable table{
        .name = name_, .rows = catoms_.size(), .columns = {{.name = kCatomColumn, .data = catoms_.data()}}, .same = table_same_};
    for (const Argument& argument : arguments_) table.columns.push_back(argument.cells(argument.name, argument.all, false));
    tables.push_back(std::move(table));
}

}  // namespace meld::record
