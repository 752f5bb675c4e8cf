// The secret in the link of a viewer: whoever does not know it gets nothing from its server.
#pragma once

#include <string>
#include <string_view>

#include "runtime/base/error.h"

namespace meld::view {

// 128 random bits of the system, as 32 hexadecimal digits. Errors: the system gives none.
Result<std::string> make_token();

// Takes as long wherever the two differ, so that nobody can find the secret digit by digit.
bool same_secret(std::string_view secret, std::string_view given);

}  // namespace meld::view
