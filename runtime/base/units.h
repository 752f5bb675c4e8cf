// Numbers as people write and read them: "2M" catoms, "16GiB", "1.5 h"; parsing and printing. Independent of the locale.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>

#include "runtime/base/error.h"

namespace meld {

// A number with an optional suffix k, M, G, T, P (powers of 1000) or Ki, Mi, Gi, Ti, Pi (powers of 1024); K means k. Blanks are allowed
// around the number. Errors name the text and what is wrong with it.
Result<double> parse_number(std::string_view text);

// As parse_number, for a whole number that is not negative: "2M", "1.5k", "1e6". Exact up to 2^64-1 when written without a fraction.
Result<std::uint64_t> parse_count(std::string_view text);

// As parse_count, with an optional B after the suffix: "16GiB", "1.5 MB", "512". A fraction of a byte is rounded.
Result<std::uint64_t> parse_bytes(std::string_view text);

// Seconds, from "90", "250ms", "5 us", "10s", "3min", "1.5h" or "2d".
Result<double> parse_duration(std::string_view text);

// "12.3 MiB"; below a KiB "512 B". Three significant digits or more.
std::string format_bytes(std::uint64_t bytes);
// "1.2 M", "950", "12 k", "0.25"; two or three significant digits, for rates as well as counts.
std::string format_count(double count);
// "1,234,567".
std::string grouped(std::uint64_t n);
// "1.2 ms", "35 s", "4 min 05 s", "2 h 07 min", "3 d 04 h".
std::string format_duration(double seconds);

}  // namespace meld
