#include "runtime/sim/core/setup/robot_facts.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <map>
#include <optional>
#include <span>
#include <string>
#include <string_view>

#include "runtime/base/assert.h"
#include "runtime/engine/tuple/facts.h"
#include "runtime/engine/tuple/value_text.h"

namespace meld::sim {
namespace {

constexpr std::string_view kPart = "part", kRobot = "robot";

ValueType kind_of(const ModuleInfo& module, const PredicateInfo& p, u32 field) { return tuple::type_of(module, p.fields[field]).kind(); }

// Facts that the text states are the program's own, whatever their names.
bool text_states(const ModuleInfo& module, u32 predicate) {
    return std::ranges::any_of(std::span(module.rules, module.rule_count), [&](const RuleInfo& r) {
        return r.at != kEverywhere && std::find(r.heads, r.heads + r.head_count, predicate) != r.heads + r.head_count;
    });
}

bool is_given_part(const ModuleInfo& module, const PredicateInfo& p) {
    return p.name == kPart && p.arity == 2 && kind_of(module, p, 0) == ValueType::Node && kind_of(module, p, 1) == ValueType::String;
}

bool is_given_robot(const ModuleInfo& module, const PredicateInfo& p) {
    return p.name == kRobot && p.arity == 1 && kind_of(module, p, 0) == ValueType::Int;
}

class RobotFacts {
  public:
    explicit RobotFacts(Subdomain& subdomain) : subdomain_(subdomain), robots_(*subdomain.world.robots) {}

    void give_parts(const PredicateInfo& p, Catom catom, const world::RobotPart& self) {
        const world::Assembly& assembly = robots_.assemblies()[self.assembly];
        for (std::size_t i = 0; i < assembly.parts.size(); ++i) {
            const std::array values{Value{.catom = self.first_catom + i},
                                    text(tuple::type_of(subdomain_.module, p.fields[1]), assembly.parts[i])};
            subdomain_.give(p.base, catom, values.data());
        }
    }

    void give_number(const PredicateInfo& p, Catom catom, const world::RobotPart& self) {
        const Value number{.integer = static_cast<i64>(self.robot)};
        subdomain_.give(p.base, catom, &number);
    }

  private:
    // Made once for all robots.
    Value text(tuple::Type type, const std::string& name) {
        const auto known = texts_.find(name);
        if (known != texts_.end()) return known->second;
        const auto value = tuple::parse_value(type, fmt::format("\"{}\"", name), scratch_);
        MELD_CHECK(value.has_value(), "the name of a part, {}", name);
        return texts_.emplace(name, *value).first->second;
    }

    Subdomain& subdomain_;
    const world::Robots& robots_;
    std::map<std::string, Value> texts_;
    tuple::Arena scratch_;
};

}  // namespace

bool robots_give(const ModuleInfo& module, const world::World& world, u32 predicate) {
    const PredicateInfo& p = module.predicates[predicate];
    const bool may_be_given = !p.auxiliary && p.base != kNone16 && p.column != kNone16;
    return world.robots && world.robots->count() > 0 && may_be_given && (is_given_part(module, p) || is_given_robot(module, p)) &&
           !text_states(module, predicate);
}

void give_robot_facts(Subdomain& subdomain, const std::vector<Catom>* only) {
    const ModuleInfo& module = subdomain.module;
    for (u32 i = 0; i < module.predicate_count; ++i) {
        if (!robots_give(module, subdomain.world, i)) continue;
        RobotFacts facts(subdomain);
        const PredicateInfo& p = module.predicates[i];
        const std::size_t count = only != nullptr ? only->size() : subdomain.ensemble.index_count();
        for (std::size_t n = 0; n < count; ++n) {
            const Catom catom = only != nullptr ? (*only)[n] : static_cast<Catom>(n);
            if (!subdomain.owned(catom)) continue;
            const std::optional<world::RobotPart> self = subdomain.world.robots->of(subdomain.ensemble.id(catom));
            if (!self) continue;
            if (is_given_part(module, p))
                facts.give_parts(p, catom, *self);
            else
                facts.give_number(p, catom, *self);
        }
    }
}

}  // namespace meld::sim
