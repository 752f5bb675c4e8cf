#include "runtime/ask/query/aggregates.h"

#include <type_traits>
#include <utility>

#include "runtime/ask/query/values.h"
#include "runtime/base/assert.h"
#include "runtime/module/kernel/aggregates.h"

namespace meld::inspect {

namespace {

using check::Aggregate;
using check::AggregateInfo;
using check::Type;

// An aggregate as the kernel computes it.
template <class V, class Of>
class OfKernel : public Accumulator {
  public:
    OfKernel(Scratch& scratch, Type value_type, bool needs_match, Of of)
        : Accumulator(std::move(value_type)), scratch_(scratch), needs_match_(needs_match), of_(of) {}
    void add(Value value) override { of_.add(scratch_, 0, value_as<V>(value)); }
    std::optional<Value> result() override {
        if (needs_match_ && of_.count == 0) return std::nullopt;
        return make_value(of_.result(scratch_, 0));
    }

  private:
    Scratch& scratch_;
    bool needs_match_;
    Of of_;
};

// A function of the program: f(so far, value).
class Fold : public Accumulator {
  public:
    Fold(Terms& terms, check::FunctionId function, Type value_type, std::optional<Value> initial)
        : Accumulator(std::move(value_type)), terms_(terms), function_(function), so_far_(initial) {}
    void add(Value value) override { so_far_ = so_far_ ? terms_.call(function_, {*so_far_, value}) : value; }
    std::optional<Value> result() override { return so_far_; }

  private:
    Terms& terms_;
    check::FunctionId function_;
    std::optional<Value> so_far_;
};

}  // namespace

std::unique_ptr<Accumulator> accumulator(const Program& program, Terms& terms, const check::Clause& c, const Type& result,
                                         Values& variables) {
    if (c.aggregate == Aggregate::Custom) {
        const check::Function& f = program.checked().functions[c.fold];
        std::optional<Value> initial;
        if (c.parameter.op != check::Op::Anonymous) initial = terms.element(c.parameter, result, variables);
        return std::make_unique<Fold>(terms, c.fold, f.variables[check::VariableId(1)].type, initial);
    }
    const AggregateInfo& about = info(c.aggregate);
    const Type value = about.result == AggregateInfo::Result::ListOf ? result.parts.at(0) : result;
    const bool needs_match = about.of_nothing.empty();
    Scratch& scratch = terms.scratch;
    const auto make = [&]<class V>(std::type_identity<V>, auto of) -> std::unique_ptr<Accumulator> {
        return std::make_unique<OfKernel<V, decltype(of)>>(scratch, value, needs_match, of);
    };
    // Calls with the kernel's parameter for values of this type.
    const auto by_type = [&](const auto& call) -> std::unique_ptr<Accumulator> {
        switch (value.kind) {
            case Type::Kind::Float:
                return call(std::type_identity<double>{});
            case Type::Kind::Bool:
                return call(std::type_identity<bool>{});
            case Type::Kind::Node:
                return call(std::type_identity<u64>{});
            case Type::Kind::Int:
            case Type::Kind::Error:
                return call(std::type_identity<i64>{});
            default:
                return call(std::type_identity<ListRef>{});
        }
    };
    const auto number = [&] { return terms.types.number(value); };
    switch (c.aggregate) {
        case Aggregate::Count:
            return make(std::type_identity<i64>{}, CountOf<i64>{});
        case Aggregate::Sum:
            if (value == Type::Vec3) return make(std::type_identity<ListRef>{}, SumOf<Vector>{});
            if (value.compound()) return make(std::type_identity<ListRef>{}, SumOf<ListRef>{});
            return value == Type::Float ? make(std::type_identity<double>{}, SumOf<double>{})
                                        : make(std::type_identity<i64>{}, SumOf<i64>{});
        case Aggregate::Avg:
            return make(std::type_identity<double>{}, AvgOf<double>{});
        case Aggregate::And:
            return make(std::type_identity<bool>{}, AndOf<bool>{});
        case Aggregate::Or:
            return make(std::type_identity<bool>{}, OrOf<bool>{});
        case Aggregate::Min:
            return by_type([&]<class V>(std::type_identity<V> tag) -> std::unique_ptr<Accumulator> {
                if constexpr (std::is_same_v<V, ListRef>)
                    return make(tag, MinOf<V>{terms.types.table(), number()});
                else
                    return make(tag, MinOf<V>{});
            });
        case Aggregate::Max:
            return by_type([&]<class V>(std::type_identity<V> tag) -> std::unique_ptr<Accumulator> {
                if constexpr (std::is_same_v<V, ListRef>)
                    return make(tag, MaxOf<V>{terms.types.table(), number()});
                else
                    return make(tag, MaxOf<V>{});
            });
        case Aggregate::Collect:
            return by_type([&]<class V>(std::type_identity<V> tag) { return make(tag, CollectOf<V>{}); });
        case Aggregate::MinK:
        case Aggregate::MaxK: {
            const i64 limit = terms.value(c.parameter, variables).integer;
            const u16 type = number();
            return by_type([&]<class V>(std::type_identity<V> tag) {
                return c.aggregate == Aggregate::MinK ? make(tag, MinKOf<V>{terms.types.table(), type, limit})
                                                      : make(tag, MaxKOf<V>{{terms.types.table(), type, limit}});
            });
        }
        default:
            break;
    }
    MELD_CHECK(false, "a question aggregates by {}", about.word);
}

}  // namespace meld::inspect
