// What catoms are coloured by, kept for all of them by their numbers: a frame needs the values of those that it shows, and colours mean
// what all values make of them.
#pragma once

#include <cstddef>
#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "runtime/show/picture/catom_values.h"
#include "runtime/show/picture/frame.h"

namespace meld::view {

class KeptValues {
  public:
    using Kind = picture::CatomValues::Kind;
    explicit KeptValues(Kind kind) : kind_(kind) {}

    void resize(std::size_t catoms);
    // The value of a catom: the bits of a number, or a word's number; or none. Returns whether that is another one than before.
    bool set(std::uint64_t catom, std::optional<std::uint64_t> value);
    // The number of a word, as long as some catom has it; the catom that gets it is the next one that is set.
    std::uint64_t word(const std::string& text);

    // The value of a catom as that of the one at this place in a frame.
    void put(std::uint64_t catom, std::size_t place, picture::Frame& frame) const;
    // Few values that stand for all: a palette that has them knows what colours mean. Cost: a look at all values of chunks of catoms
    // in which one has changed since the last call.
    picture::Frame witness();

  private:
    static constexpr std::size_t kChunk = 4096;
    // More numbers than have a colour each.
    static constexpr std::size_t kFew = 9;
    struct Chunk {
        bool known = false, any = false;
        std::uint64_t low = 0, high = 0;
        std::vector<std::uint64_t> few = {};  // Values that differ, at most kFew.
    };
    bool has(std::size_t catom) const { return (has_[catom / 64] >> (catom % 64) & 1) != 0; }
    render::Number number(std::uint64_t bits) const;
    void give_back(std::uint64_t word);
    template <class Less>
    void look(std::size_t chunk, const Less& less);

    Kind kind_;
    std::vector<std::uint64_t> values_, has_;  // By catom.
    std::vector<Chunk> chunks_;                // Of numbers.
    std::vector<std::string> words_;
    std::vector<std::size_t> counts_;  // How many catoms have each word.
    std::vector<std::uint64_t> free_;  // Words that nobody has.
    std::map<std::string, std::uint64_t> by_text_;
};

}  // namespace meld::view
