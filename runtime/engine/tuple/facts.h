// Facts of any predicate as plain values: to read, give and take. For all code except the module itself.
#pragma once

#include <array>
#include <functional>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "runtime/base/error.h"
#include "runtime/engine/tuple/columns.h"
#include "runtime/module/abi/module_abi.h"

namespace meld::tuple {

// The predicate with this name and number of arguments after the catom.
std::optional<u32> find_predicate(const ModuleInfo& module, std::string_view name, std::size_t arity);
// The same if it is an action or sensed: a program may use a name that the runtime knows for something else.
std::optional<u32> find_action(const ModuleInfo& module, std::string_view name, std::size_t arity);
std::optional<u32> find_sensed(const ModuleInfo& module, std::string_view name, std::size_t arity);

// Calls visit(arguments) for each stored fact of a predicate at a catom, in the order of its group. PerLink facts name
// their neighbour by id. World predicates hold nothing here.
void each_fact(const ModuleInfo& module, const Columns& columns, const Geometry& geometry, u32 predicate, u32 catom,
               const std::function<void(const Value*)>& visit);
// The same for many catoms, one after the other: visit(catom, arguments).
void each_fact_of(const ModuleInfo& module, const Columns& columns, const Geometry& geometry, u32 predicate, std::span<const u32> catoms,
                  const std::function<void(u32, const Value*)>& visit);

// The same with the rank of each fact, kAbsent where the predicate has none, until visit(arguments, rank) says false; that is returned.
// `room` is memory for the arguments of one fact, which is used by nobody else meanwhile.
bool each_ranked_fact(const ModuleInfo& module, const Columns& columns, const Geometry& geometry, u32 predicate, u32 catom,
                      std::vector<Value>& room, const std::function<bool(const Value*, u32)>& visit);
// How many facts of a predicate are stored at a catom, without looking at them.
u32 count_facts(const ModuleInfo& module, const Columns& columns, const Geometry& geometry, u32 predicate, u32 catom);

// Adds a fact to a predicate that may be given facts (linear: always; persistent and sensed: if it is not there). A Single is replaced.
// Lists among the arguments are copied, so they may be in any memory. Returns whether anything changed. The caller marks the catom with the
// column's own_dirty.
bool give_fact(const ModuleInfo& module, Columns& columns, u32 predicate, u32 catom, const Value* arguments, int pool);
// The same for many facts of a predicate stored in rows at one catom, in any order. Cost: one sort of them and one pass over the existing
// rows. Sorts the facts; `rows` is memory that may be reused between calls.
bool give_facts(const ModuleInfo& module, Columns& columns, u32 predicate, u32 catom, std::vector<const Value*>& facts,
                std::vector<u8>& rows, int pool);
// Removes a given fact; returns whether it was there.
bool take_fact(const ModuleInfo& module, Columns& columns, u32 predicate, u32 catom, const Value* arguments, int pool);

// For measured values: the numbers of the one fact that a predicate has at a catom, if there is one. They are its arguments, or the items
// of its only argument, a vec3. No lists are copied.
struct Numbers {
    std::array<double, 4> at{};
    std::size_t count = 0;  // 0: there is no fact.
};
Numbers read_numbers(const ModuleInfo& module, const Columns& columns, u32 predicate, u32 catom);
// Replaces the fact by one of this many numbers, without a new list if the catom alone has the former one. Different threads may do so for
// different catoms, each with its own pool. The caller marks the catom.
void give_numbers(const ModuleInfo& module, Columns& columns, u32 predicate, u32 catom, const Numbers& numbers, int pool);

// "dist(@42, 7)", as a program could write it.
std::string print_fact(const ModuleInfo& module, const PredicateInfo& predicate, u64 id, const Value* arguments);
// Three-way, by arguments in order.
int compare_arguments(const ModuleInfo& module, const PredicateInfo& predicate, const Value* a, const Value* b);
// By content, the catom's id first.
u64 hash_arguments(const ModuleInfo& module, const PredicateInfo& predicate, u64 start, const Value* arguments);

}  // namespace meld::tuple
