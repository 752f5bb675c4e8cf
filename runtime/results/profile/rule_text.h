// A rule of a profile, on one line.
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>

namespace meld::profile {

// "dist@10  dist(B, D + 1) :- neighbor(A, B), dist(A, D)."
std::string rule_text(const nlohmann::ordered_json& rule);

}  // namespace meld::profile
