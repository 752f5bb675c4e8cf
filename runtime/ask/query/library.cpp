#include "runtime/ask/query/library.h"

#include <array>
#include <bit>
#include <cstddef>
#include <tuple>
#include <type_traits>
#include <utility>

#include "runtime/ask/query/values.h"
#include "runtime/module/kernel/library.h"

namespace meld::inspect {

namespace {

// How each signature is called; functions that compare elements take their type first.
template <auto Function>
struct Caller;
template <class R, class... A, R (*Function)(Eval&, u32, A...)>
struct Caller<Function> {
    using Parameters = std::tuple<A...>;
    static constexpr bool kTyped = [] {
        if constexpr (sizeof...(A) > 0) return std::is_same_v<std::tuple_element_t<0, Parameters>, const TypeInfo*>;
        return false;
    }();

    static Value call(Eval& e, [[maybe_unused]] const TypeInfo* types, [[maybe_unused]] u16 type, const Value* arguments) {
        constexpr std::size_t kBefore = kTyped ? 2 : 0;
        return [&]<std::size_t... I>(std::index_sequence<I...>) {
            if constexpr (kTyped)
                return make_value(
                    Function(e, e.rule, types, type, value_as<std::tuple_element_t<I + kBefore, Parameters>>(arguments[I])...));
            else
                return make_value(Function(e, e.rule, value_as<std::tuple_element_t<I, Parameters>>(arguments[I])...));
        }(std::make_index_sequence<sizeof...(A) - kBefore>{});
    }
};

struct Entry {
    std::string_view name;
    LibraryCall ints, reals;
};
#define MELD_ONE(name) \
    Entry { #name, Caller<&library::name>::call, Caller<&library::name>::call }
constexpr std::array kFunctions = {
    MELD_ONE(truncate_to),
    MELD_ONE(floor),
    MELD_ONE(ceil),
    MELD_ONE(round),
    MELD_ONE(pow),
    MELD_ONE(power),
    MELD_ONE(exp),
    MELD_ONE(log),
    MELD_ONE(sin),
    MELD_ONE(cos),
    MELD_ONE(tan),
    MELD_ONE(asin),
    MELD_ONE(acos),
    MELD_ONE(atan),
    MELD_ONE(atan2),
    MELD_ONE(sigmoid),
    MELD_ONE(length),
    MELD_ONE(nth),
    MELD_ONE(first),
    MELD_ONE(tail),
    MELD_ONE(last),
    MELD_ONE(append),
    MELD_ONE(add_last),
    MELD_ONE(reverse),
    MELD_ONE(sort),
    MELD_ONE(exists),
    MELD_ONE(index_of),
    MELD_ONE(count),
    MELD_ONE(take),
    MELD_ONE(drop),
    MELD_ONE(sublist),
    MELD_ONE(remove),
    MELD_ONE(difference),
    MELD_ONE(common),
    MELD_ONE(list_union),
    MELD_ONE(unique),
    MELD_ONE(subset),
    MELD_ONE(meets),
    MELD_ONE(equal),
    MELD_ONE(least),
    MELD_ONE(greatest),
    MELD_ONE(to_set),
    MELD_ONE(same),
    MELD_ONE(member),
    MELD_ONE(set_add),
    MELD_ONE(set_union),
    MELD_ONE(replace),
    MELD_ONE(repeated),
    MELD_ONE(characters),
    MELD_ONE(join),
    MELD_ONE(substring),
    MELD_ONE(letters),
    MELD_ONE(from_int),
    MELD_ONE(from_real),
    MELD_ONE(from_node),
    MELD_ONE(to_int),
    MELD_ONE(to_ints),
    MELD_ONE(to_real),
    MELD_ONE(x),
    MELD_ONE(y),
    MELD_ONE(z),
    MELD_ONE(dot),
    MELD_ONE(cross),
    MELD_ONE(norm),
    MELD_ONE(distance),
    MELD_ONE(normalize),
    MELD_ONE(nearest_rotation),
    MELD_ONE(align),
    MELD_ONE(damp),
    MELD_ONE(divide),
    MELD_ONE(convolve),
    MELD_ONE(add_floats),
    MELD_ONE(residual),
    Entry{"sum", Caller<&library::sum<i64>>::call, Caller<&library::sum<double>>::call},
};
#undef MELD_ONE

}  // namespace

LibraryCall library_call(std::string_view cpp, bool real) {
    for (const Entry& entry : kFunctions)
        if (entry.name == cpp) return real ? entry.reals : entry.ints;
    return nullptr;
}

}  // namespace meld::inspect
