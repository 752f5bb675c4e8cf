// What is watched in a run, as a file of rules says it:
//
//     stop("two leaders", A, B) :- leader(A), leader(B), neighbor(A, B).
//     tell(A, D) :- dist(A, D), D > 9.
//     expect() :- leader(A).
#pragma once

#include <string>
#include <vector>

#include "compiler/front/carried.h"
#include "runtime/base/error.h"

namespace meld::front {

struct WatchRule {
    enum class Verb { Stop, Tell, Expect, Never } verb = Verb::Stop;
    std::string name = {};                // Empty: the text of the body.
    std::vector<std::string> shown = {};  // Variables whose values are told; none: all.
    Asked asked = {};
    std::string body = {};  // As it is written.
};

// The rules of a file with this text. Errors: mistakes, each at its place; a body is not looked at.
Result<std::vector<WatchRule>> read_watch_rules(const std::string& path, const std::string& text);

}  // namespace meld::front
