#include "runtime/ask/query/sieve.h"

#include <algorithm>
#include <cstring>
#include <numeric>
#include <utility>

#include "runtime/engine/tuple/field.h"

namespace meld::inspect {

using check::Op;
using Kind = Instruction::Kind;

namespace {

SieveCode code_of(const Program& program, const check::Rule& rule, check::VariableId start, const sim::Subdomain& subdomain) {
    Bound bound(rule.variables.count());
    bound[start.index()] = true;
    return sieve_code(program, rule, order(program, rule, rule.body, bound, false), start, subdomain.view());
}

// Calls go(compare), where compare(a, b) tells of two values.
template <class Of, class Go>
void with_comparison(Op op, const Of& of, const Go& go) {
    switch (op) {
        case Op::Equal:
            return go([&](Value a, Value b) { return of(a) == of(b); });
        case Op::NotEqual:
            return go([&](Value a, Value b) { return of(a) != of(b); });
        case Op::Less:
            return go([&](Value a, Value b) { return of(a) < of(b); });
        case Op::LessEqual:
            return go([&](Value a, Value b) { return of(a) <= of(b); });
        case Op::Greater:
            return go([&](Value a, Value b) { return of(a) > of(b); });
        default:
            return go([&](Value a, Value b) { return of(a) >= of(b); });
    }
}
template <class Go>
void with_comparison(Op op, bool real, const Go& go) {
    if (real)
        with_comparison(op, [](Value v) { return v.real; }, go);
    else
        with_comparison(op, [](Value v) { return v.integer; }, go);
}

}  // namespace

Sieve::Sieve(const Program& program, const check::Rule& rule, check::VariableId start, const sim::Subdomain& subdomain)
    : subdomain_(subdomain), code_(code_of(program, rule, start, subdomain)), levels_(code_.levels), kept_(kRows), lookups_(code_.lookups) {
    for (Level& level : levels_) {
        level.cells.resize(std::size_t{code_.registers} * kRows);
        for (const SieveCode::Fixed& f : code_.fixed) std::fill_n(level.cells.data() + std::size_t{f.at} * kRows, kRows, f.value);
    }
}

std::vector<u64> Sieve::pass(std::span<const u32> catoms) {
    std::vector<u64> out;
    for (std::size_t from = 0; from < catoms.size(); from += kRows) {
        const auto some = catoms.subspan(from, std::min<std::size_t>(kRows, catoms.size() - from));
        std::ranges::fill(kept_, 0);
        Level& first = levels_[0];
        first.left.resize(some.size());
        std::iota(first.left.begin(), first.left.end(), 0);
        for (const u32 row : first.left) {
            cells(0, SieveCode::kOrigin)[row].catom = row;
            cells(0, SieveCode::kStart)[row].catom = some[row];
        }
        run(code_.instructions, 0, 0, SieveCode::kOrigin, kept_);
        for (RowLookups& lookups : lookups_) lookups.clear();
        for (std::size_t row = 0; row < some.size(); ++row)
            if (kept_[row] != 0) out.push_back(subdomain_.ensemble.id(some[row]));
    }
    return out;
}

template <class Holds>
void Sieve::filter(u32 level, const Holds& holds) {
    std::vector<u32>& left = levels_[level].left;
    std::size_t kept = 0;
    for (const u32 row : left) {
        left[kept] = row;
        kept += holds(row) ? 1 : 0;
    }
    left.resize(kept);
}

void Sieve::run(const Code& code, std::size_t at, u32 level, Register by, std::vector<i64>& ends) {
    for (; at < code.size() && !levels_[level].left.empty(); ++at) {
        const Instruction& i = code[at];
        switch (i.kind) {
            case Kind::Find:
                find(i, level);
                break;
            case Kind::Number: {
                const Geometry& g = subdomain_.geometry();
                const Value* const catom = cells(level, i.a);
                Value* const to = cells(level, i.to);
                for (const u32 row : levels_[level].left) to[row].catom = id_of(g, static_cast<u32>(catom[row].catom));
                break;
            }
            case Kind::Read:
                read(i, level);
                break;
            case Kind::Compute:
                compute(i, level);
                break;
            case Kind::Test:
                test(i, level);
                break;
            case Kind::Keep: {
                const Value* const holds = cells(level, i.a);
                filter(level, [&](u32 row) { return holds[row].integer != 0; });
                break;
            }
            case Kind::Not:
            case Kind::Count:
                part(i, level);
                break;
            case Kind::Rows:
                return rows(code, at, level, by, ends);
            case Kind::Links: {
                const Geometry& g = subdomain_.geometry();
                const Value* const place = cells(level, i.a);
                Value* const to = cells(level + 1, i.to);
                return make(code, at, level, by, ends, [&](u32 row, const auto& add) {
                    const auto catom = static_cast<u32>(place[row].catom);
                    if (!here(level, row, catom)) return;
                    each_link(g, catom, [&](i32 port, u32 other) {
                        const u32 made = add();
                        to[made].catom = other;
                        if (i.port) cells(level + 1, *i.port)[made].integer = i.back ? port_there(g, catom, port) : port;
                    });
                });
            }
        }
    }
    const Value* const whose = cells(level, by);
    for (const u32 row : levels_[level].left) ++ends[whose[row].catom];
}

template <class Each>
void Sieve::make(const Code& code, std::size_t at, u32 level, Register by, std::vector<i64>& ends, const Each& each) {
    const std::vector<Register>& carried = code[at].carried;
    Level& next = levels_[level + 1];
    const Value* const origin = cells(level, SieveCode::kOrigin);
    const auto go_on = [&] {
        next.left.resize(next.made);
        std::iota(next.left.begin(), next.left.end(), 0);
        rows_made_ += std::exchange(next.made, 0);
        run(code, at + 1, level + 1, by, ends);
    };
    next.made = 0;
    for (const u32 row : levels_[level].left) {
        // Nothing more can be learned of its catom.
        if (kept_[origin[row].catom] != 0) continue;
        each(row, [&] {
            if (next.made == kRows) go_on();
            for (const Register r : carried) cells(level + 1, r)[next.made] = cells(level, r)[row];
            return next.made++;
        });
    }
    go_on();
}

void Sieve::rows(const Code& code, std::size_t at, u32 level, Register by, std::vector<i64>& ends) {
    const Instruction& i = code[at];
    const PredicateInfo& p = subdomain_.module.predicates[i.predicate];
    const std::size_t size = subdomain_.module.columns[p.column].row_bytes;
    const Value* const place = cells(level, i.a);
    std::vector<i64> wanted(i.key.size());
    make(code, at, level, by, ends, [&](u32 row, const auto& add) {
        const auto catom = static_cast<u32>(place[row].catom);
        if (!here(level, row, catom)) return;
        const RowsHead& head = subdomain_.columns.rows(p.column, catom);
        const auto take = [&](u32 r) {
            const u32 made = add();
            for (const Instruction::Field& f : i.fields) cells(level + 1, f.to)[made] = tuple::load_field(*f.info, head.data + r * size);
        };
        const RowLookup* const lookup =
            head.count > RowLookups::kScanned && !i.key.empty() ? lookups_[i.lookup].at(catom, head, size, i.key) : nullptr;
        if (lookup == nullptr) {
            for (u32 r = 0; r < head.count; ++r) take(r);
            return;
        }
        for (std::size_t k = 0; k < i.key.size(); ++k) wanted[k] = cells(level, i.key[k].to)[row].integer;
        lookup->each(wanted, take);
    });
}

void Sieve::part(const Instruction& i, u32 level) {
    Level& outer = levels_[level];
    Level& inner = levels_[level + 1];
    outer.ends.assign(kRows, 0);
    for (const u32 row : outer.left) {
        for (const Register r : i.carried) cells(level + 1, r)[row] = cells(level, r)[row];
        cells(level + 1, i.b)[row].catom = row;
    }
    inner.left = outer.left;
    run(i.inner, 0, level + 1, i.b, outer.ends);
    if (i.kind == Kind::Not) return filter(level, [&](u32 row) { return outer.ends[row] == 0; });
    for (const u32 row : outer.left) cells(level, i.to)[row].integer = outer.ends[row];
}

bool Sieve::here(u32 level, u32 row, u32 catom) {
    if (subdomain_.alone() || subdomain_.owned(catom)) return true;
    undecided(level, row);
    return false;
}

void Sieve::find(const Instruction& i, u32 level) {
    const Value* const number = cells(level, i.a);
    Value* const to = cells(level, i.to);
    filter(level, [&](u32 row) {
        const auto found = subdomain_.ensemble.find(number[row].catom);
        if (found) to[row].catom = *found;
        if (!found && !subdomain_.alone()) undecided(level, row);
        return found.has_value();
    });
}

void Sieve::read(const Instruction& i, u32 level) {
    const PredicateInfo& p = subdomain_.module.predicates[i.predicate];
    const Value* const place = cells(level, i.a);
    const u8* const records = subdomain_.columns.pointers()[p.column];
    const std::size_t stride = subdomain_.module.columns[p.column].stride;
    const bool alone = subdomain_.alone();
    const auto word = [](const u8* record, u32 offset) {
        u32 out = 0;
        std::memcpy(&out, record + offset, sizeof out);
        return out;
    };
    const auto holds = [&](const auto& present) {
        filter(level, [&](u32 row) {
            const auto catom = static_cast<u32>(place[row].catom);
            return (alone || here(level, row, catom)) && present(records + catom * stride);
        });
    };
    if (p.rank_offset != kNone32)
        holds([&](const u8* record) { return word(record, p.rank_offset) != kAbsent; });
    else
        holds([&](const u8* record) { return (record[p.presence_offset] & p.presence_mask) != 0; });
    for (const Instruction::Field& f : i.fields) {
        Value* const to = cells(level, f.to);
        for (const u32 row : levels_[level].left) to[row] = tuple::load_field(*f.info, records + place[row].catom * stride);
    }
}

void Sieve::compute(const Instruction& i, u32 level) {
    const Value *const a = cells(level, i.a), *const b = cells(level, i.b);
    Value* const to = cells(level, i.to);
    const auto each = [&](const auto& value) {
        for (const u32 row : levels_[level].left) to[row] = value(a[row], b[row]);
    };
    const auto checked = [&](const auto& fails) {
        filter(level, [&](u32 row) {
            if (!fails(a[row].integer, b[row].integer, &to[row].integer)) return true;
            undecided(level, row);
            return false;
        });
    };
    switch (i.op) {
        case Op::Add:
            return i.real ? each([](Value x, Value y) { return Value{.real = x.real + y.real}; })
                          : checked([](i64 x, i64 y, i64* z) { return __builtin_add_overflow(x, y, z); });
        case Op::Subtract:
            return i.real ? each([](Value x, Value y) { return Value{.real = x.real - y.real}; })
                          : checked([](i64 x, i64 y, i64* z) { return __builtin_sub_overflow(x, y, z); });
        case Op::Multiply:
            return i.real ? each([](Value x, Value y) { return Value{.real = x.real * y.real}; })
                          : checked([](i64 x, i64 y, i64* z) { return __builtin_mul_overflow(x, y, z); });
        case Op::Min:
            return each([](Value x, Value y) { return Value{.integer = std::min(x.integer, y.integer)}; });
        case Op::Max:
            return each([](Value x, Value y) { return Value{.integer = std::max(x.integer, y.integer)}; });
        case Op::And:
            return each([](Value x, Value y) { return Value{.integer = x.integer & y.integer}; });
        case Op::Or:
            return each([](Value x, Value y) { return Value{.integer = x.integer | y.integer}; });
        case Op::Not:
            return each([](Value x, Value) { return Value{.integer = x.integer == 0}; });
        case Op::ToFloat:
            return each([](Value x, Value) { return Value{.real = static_cast<double>(x.integer)}; });
        default:
            with_comparison(i.op, i.real,
                            [&](const auto& compare) { each([&](Value x, Value y) { return Value{.integer = compare(x, y)}; }); });
    }
}

void Sieve::test(const Instruction& i, u32 level) {
    const Value *const a = cells(level, i.a), *const b = cells(level, i.b);
    with_comparison(i.op, i.real, [&](const auto& compare) { filter(level, [&](u32 row) { return compare(a[row], b[row]); }); });
}

}  // namespace meld::inspect
