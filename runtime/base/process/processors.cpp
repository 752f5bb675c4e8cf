#include "runtime/base/process/processors.h"

#include <sched.h>

#include <algorithm>

namespace meld {

int processors() {
    cpu_set_t set;
    CPU_ZERO(&set);
    const int available = sched_getaffinity(0, sizeof set, &set) == 0 ? CPU_COUNT(&set) : 1;
    return std::clamp(available, 1, 64);
}

}  // namespace meld
