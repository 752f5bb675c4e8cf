// Where the bodies in a snapshot are, for somebody who looks at them and does not go on.
#pragma once

#include <span>

#include "runtime/base/bytes.h"
#include "runtime/base/error.h"
#include "runtime/sim/core/subdomain.h"

namespace meld::sim {

// Places catoms of a chunk, and what their programs have sensed of it, as FreeMotion::save_catoms wrote it; no bodies are made. On one
// process. Errors: the bytes end too early, or a catom has no body.
Result<void> place_saved_bodies(Subdomain& subdomain, std::span<const tuple::SavedCatom> catoms, ByteReader& in);

}  // namespace meld::sim
