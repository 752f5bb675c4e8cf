#include "compiler/check/program/op_info.h"

#include <cstddef>
#include <iterator>

#include "runtime/base/assert.h"

namespace meld::check {

namespace {

using Family = OpInfo::Family;
constexpr std::int8_t kMany = OpInfo::kMany;
constexpr std::uint8_t kPartial = OpInfo::kPartial, kOverflows = OpInfo::kOverflows, kDraws = OpInfo::kDraws, kDear = OpInfo::kDear,
                       kMoves = OpInfo::kMoves, kOffers = OpInfo::kOffers;

// clang-format off
constexpr OpInfo kOps[] = {
    {Op::Variable,     Family::Leaf,       0,     kMoves | kOffers},
    {Op::Anonymous,    Family::Leaf,       0},
    {Op::Int,          Family::Leaf,       0,     kMoves | kOffers},
    {Op::Float,        Family::Leaf,       0,     kMoves | kOffers},
    {Op::Bool,         Family::Leaf,       0,     kMoves | kOffers},
    {Op::Node,         Family::Leaf,       0,     kMoves},
    {Op::Constant,     Family::Leaf,       0,     kMoves | kOffers},
    {Op::String,       Family::Compound,   0},
    {Op::WorldSize,    Family::Run,        0},
    {Op::List,         Family::Compound,   kMany, kDear},
    {Op::Cons,         Family::Compound,   2,     kDear},
    {Op::Struct,       Family::Compound,   kMany, kDear},
    {Op::Tuple,        Family::Compound,   kMany, kDear},
    {Op::ListHead,     Family::Compound,   1},
    {Op::ListTail,     Family::Compound,   1},
    {Op::IsEmpty,      Family::Compound,   1},
    {Op::Item,         Family::Compound,   1},
    {Op::Let,          Family::Control,    2},
    {Op::Call,         Family::Call,       kMany, kPartial | kDear},
    {Op::Library,      Family::Call,       kMany, kPartial | kDear},
    {Op::Now,          Family::Run,        0},
    {Op::Ticks,        Family::Run,        1},
    {Op::Due,          Family::Run,        1,     kDraws},
    {Op::Fresh,        Family::Run,        0,     kDraws},
    {Op::NewNode,      Family::Run,        0,     kDraws},
    {Op::NextHop,      Family::Run,        1},
    {Op::Negate,       Family::Number,     1,     kOverflows | kOffers},
    {Op::Not,          Family::Control,    1,     kMoves | kOffers},
    {Op::ToFloat,      Family::Number,     1,     kMoves | kOffers},
    {Op::Add,          Family::Arithmetic, 2,     kOverflows | kOffers},
    {Op::Subtract,     Family::Arithmetic, 2,     kOverflows | kOffers},
    {Op::Multiply,     Family::Arithmetic, 2,     kOverflows | kOffers},
    {Op::Divide,       Family::Arithmetic, 2,     kPartial | kDear | kOffers},
    {Op::Modulo,       Family::Arithmetic, 2,     kPartial | kDear | kOffers},
    {Op::Power,        Family::Arithmetic, 2,     kPartial | kDear},
    {Op::Append,       Family::Compound,   2,     kDear},
    {Op::Equal,        Family::Comparison, 2,     kMoves | kOffers},
    {Op::NotEqual,     Family::Comparison, 2,     kMoves | kOffers},
    {Op::Less,         Family::Comparison, 2,     kMoves | kOffers},
    {Op::LessEqual,    Family::Comparison, 2,     kMoves | kOffers},
    {Op::Greater,      Family::Comparison, 2,     kMoves | kOffers},
    {Op::GreaterEqual, Family::Comparison, 2,     kMoves | kOffers},
    {Op::And,          Family::Control,    2,     kMoves | kOffers},
    {Op::Or,           Family::Control,    2,     kMoves | kOffers},
    {Op::If,           Family::Control,    3,     kOffers},
    {Op::Min,          Family::Number,     2,     kOffers},
    {Op::Max,          Family::Number,     2,     kOffers},
    {Op::Abs,          Family::Number,     1,     kOverflows | kOffers},
    {Op::Truncate,     Family::Number,     1,     kPartial},
    {Op::Sqrt,         Family::Number,     1,     kPartial | kDear},
    {Op::NodeToInt,    Family::Number,     1},
};
// clang-format on

constexpr bool rows_follow_the_enumeration() {
    for (std::size_t i = 0; i < std::size(kOps); ++i)
        if (kOps[i].op != static_cast<Op>(i)) return false;
    return kOps[std::size(kOps) - 1].op == Op::NodeToInt;
}
static_assert(rows_follow_the_enumeration());

}  // namespace

const OpInfo& info(Op op) {
    const auto row = static_cast<std::size_t>(op);
    MELD_EXPECT(row < std::size(kOps), "operator {}", row);
    return kOps[row];
}

}  // namespace meld::check
