#include "runtime/show/view/token.h"

#include <fmt/format.h>
#include <sys/random.h>

#include <array>
#include <cerrno>
#include <cstddef>
#include <cstring>

namespace meld::view {

Result<std::string> make_token() {
    std::array<unsigned char, 16> bits{};
    ssize_t got = 0;
    do got = ::getrandom(bits.data(), bits.size(), 0);
    while (got < 0 && errno == EINTR);
    if (got != static_cast<ssize_t>(bits.size())) return fail(fmt::format("the system gives no random number: {}", std::strerror(errno)));
    std::string out;
    for (const unsigned char byte : bits) out += fmt::format("{:02x}", byte);
    return out;
}

bool same_secret(std::string_view secret, std::string_view given) {
    // Its length is known to everybody.
    if (secret.size() != given.size()) return false;
    unsigned char differs = 0;
    for (std::size_t i = 0; i < secret.size(); ++i) differs = static_cast<unsigned char>(differs | (secret[i] ^ given[i]));
    return differs == 0;
}

}  // namespace meld::view
