// What people measure of a run, as a body of Meld: an aggregate needs no name of its own there.
#pragma once

#include <string>

namespace meld::inspect {

// `count : { leader(A) } = 1` as a body of Meld, which gives the aggregate a name; any other text is one already.
std::string body_of_measure(const std::string& text);

}  // namespace meld::inspect
