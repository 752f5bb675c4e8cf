// Packs chunks of numbers as the filters "shuffle" and "deflate" of HDF5 do, so that every reader unpacks them, in much less time where
// numbers are alike. Private to runtime/results.
//
// The shuffled bytes of a chunk are planes: the first bytes of all numbers, then the second ones, and so on. Most planes of numbers that
// catoms have are the same byte throughout, or as in another chunk. Each plane is packed by itself, refers to no other, and is kept. So a
// plane that is known costs a hash at most. Of one that is not, a sample tells which way pays: bytes that repeat nothing are only coded by
// how frequent they are, and those that are random stay as they are. What a chunk becomes depends on its content alone, not on what is
// known.
#pragma once

#include <xxhash.h>

#include <cstddef>
#include <cstdint>
#include <map>
#include <memory>
#include <span>
#include <vector>

namespace meld::record {

class ChunkPacker {
  public:
    ChunkPacker();
    ~ChunkPacker();
    ChunkPacker(const ChunkPacker&) = delete;
    ChunkPacker& operator=(const ChunkPacker&) = delete;

    // As a stream of zlib; empty if it would take no less than the chunk. Elements have up to 8 bytes.
    std::vector<std::byte> pack(std::span<const std::byte> chunk, std::size_t element_bytes);

  private:
    struct Packed {
        std::vector<std::byte> bytes;
        unsigned long checksum = 0;
    };
    struct Key {
        XXH128_hash_t hash;  // Of a plane that is one byte throughout: the byte alone.
        std::size_t size;
        bool all_alike;
        bool operator<(const Key& other) const;
    };
    enum class Way { Deflate, Codes, AsItIs };
    struct Stream;
    const Packed& packed(const Key& key, std::span<const std::byte> plane);
    Way best_way(std::span<const std::byte> plane);
    std::size_t deflate(std::span<const std::byte> bytes, Way way, std::span<std::byte> to);
    void pack(std::span<const std::byte> plane, Packed& to);

    std::unique_ptr<Stream> matches_, codes_;
    std::vector<std::byte> plane_, room_;
    std::map<Key, Packed> known_;
    std::size_t known_bytes_ = 0;
};

}  // namespace meld::record
