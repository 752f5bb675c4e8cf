// What a program consists of, for whoever wants to ask about it: its rules with the lines where they stand, and its predicates.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "runtime/base/error.h"
#include "runtime/module/abi/module_abi.h"

namespace meld::debug {

struct RulesListed {
    struct Rule {
        std::string name = {}, text = {};  // As explanations name it, and it as Meld.
        std::string file = {};             // Its path from the folder of the program; of a library, its name.
        bool library = false;
        std::uint32_t line = 0, last_line = 0;
    };
    std::vector<Rule> rules = {};  // In the order in which they were read.
};

struct PredicatesListed {
    struct Predicate {
        std::string name = {}, declaration = {};
        bool own = false;  // Declared by the program, its includes or a library, not by the prelude.
    };
    std::vector<Predicate> predicates = {};  // By name.
};

// With a name, the rules that derive or make facts of that predicate. Errors: there is no such predicate; the module carries no sources.
// Cost: that of the program's front end.
Result<RulesListed> list_rules(const ModuleInfo& module, const std::string& predicate);
Result<PredicatesListed> list_predicates(const ModuleInfo& module);

}  // namespace meld::debug
