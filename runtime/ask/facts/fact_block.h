// Facts of other processes: as bytes on their way, and where they stay.
#pragma once

#include <algorithm>
#include <span>
#include <unordered_map>
#include <utility>
#include <vector>

#include "runtime/ask/facts/facts.h"
#include "runtime/base/bytes.h"
#include "runtime/engine/tuple/values.h"

namespace meld::inspect {

// The bytes are the catom that a fact was asked for by, and the fact.
inline tuple::Type type_of(const ModuleInfo& module, const Source& source, u32 argument) {
    return tuple::type_of(module, module.predicates[source.predicate].fields[argument]);
}

inline void pack(const ModuleInfo& module, const Source& source, u64 asked_by, const Fact& fact, ByteWriter& out) {
    out.write(asked_by);
    out.write(fact.catom);
    out.write(fact.rank);
    for (u32 i = 0; i < source.arity; ++i) tuple::pack(type_of(module, source, i), fact.arguments[i], out);
}

struct Block {
    struct Row {
        u64 asked_by, catom;
        u32 rank;
    };
    std::vector<Row> rows;
    std::vector<Value> values;
    tuple::Arena lists;
    std::unordered_map<u64, std::size_t> first;  // Of the rows of a catom, once they are sorted.

    void read(const ModuleInfo& module, const Source& source, std::span<const std::byte> bytes) {
        for (ByteReader in(bytes, "facts of a process"); !in.done();) {
            Row row{};
            row.asked_by = in.read<u64>();
            row.catom = in.read<u64>();
            row.rank = in.read<u32>();
            rows.push_back(row);
            for (u32 i = 0; i < source.arity; ++i) values.push_back(tuple::unpack(type_of(module, source, i), in, lists));
        }
    }
    // By catom; those of one keep their order.
    void sort(std::size_t arity) {
        std::vector<u32> order(rows.size());
        for (u32 i = 0; i < order.size(); ++i) order[i] = i;
        std::ranges::stable_sort(order, {}, [&](u32 i) { return rows[i].asked_by; });
        Block sorted;
        for (const u32 i : order) {
            sorted.rows.push_back(rows[i]);
            sorted.values.insert(sorted.values.end(), values.begin() + static_cast<std::ptrdiff_t>(i * arity),
                                 values.begin() + static_cast<std::ptrdiff_t>((i + 1) * arity));
        }
        rows = std::move(sorted.rows);
        values = std::move(sorted.values);
        first.reserve(rows.size());
        for (std::size_t row = 0; row < rows.size(); ++row) first.try_emplace(rows[row].asked_by, row);
    }
    Fact fact(std::size_t row, std::size_t arity) const {
        return {.catom = rows[row].catom, .arguments = values.data() + row * arity, .rank = rows[row].rank};
    }
    // The rows from this one on that were asked for by one catom.
    bool visit(std::size_t row, std::size_t arity, const Visit& visit) const {
        if (row == rows.size()) return true;
        for (const u64 catom = rows[row].asked_by; row < rows.size() && rows[row].asked_by == catom; ++row)
            if (!visit(fact(row, arity))) return false;
        return true;
    }
    bool visit_catom(u64 catom, std::size_t arity, const Visit& visit_one) const {
        const auto found = first.find(catom);
        return found == first.end() || visit(found->second, arity, visit_one);
    }
};

}  // namespace meld::inspect
