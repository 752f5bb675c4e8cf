// How much of the machine this process may use.
#pragma once

namespace meld {

// The processors that this process may use, at least 1 and at most 64.
int processors();

}  // namespace meld
