// The formats are those of RFC 1950 (zlib) and RFC 1951 (deflate).
#include "runtime/results/hdf5/chunk_packer.h"

#include <zlib.h>

#include <algorithm>
#include <array>
#include <cstring>
#include <tuple>

#include "runtime/base/assert.h"

namespace meld::record {

namespace {

constexpr int kLevel = 1;
constexpr int kWindowBits = -15;  // Without header and checksum.
constexpr int kMemoryLevel = 8;
constexpr std::size_t kMostElementBytes = 8;
// Planes that are known take no more than this.
constexpr std::size_t kMostKnownBytes = 4 << 20;
constexpr std::size_t kKnownBytes = 128;  // What a plane takes besides its packed bytes.

// Of a plane, from its middle.
constexpr std::size_t kSampleBytes = 4096;
// Matches of earlier bytes take five times as long as codes alone, and must save a quarter of these; codes must save a sixteenth.
constexpr std::size_t kMatchesOf = 4, kMatchesSave = 1, kCodesOf = 16, kCodesSave = 1;
constexpr std::size_t kMostStoredBytes = 65535;  // In a block.
constexpr std::size_t kBlockBytes = 5;           // Of a block, besides its bytes.

constexpr std::array kHeader = {std::byte{0x78}, std::byte{0x01}};
// An empty last block.
constexpr std::array kEnd = {std::byte{0x03}, std::byte{0x00}};

Bytef* bytes_of(const std::byte* at) { return reinterpret_cast<Bytef*>(const_cast<std::byte*>(at)); }

// In which bytes any two elements differ: all bits of these bytes that do.
template <class Element>
std::uint64_t differing_bits(std::span<const std::byte> chunk) {
    Element first{}, bits{};
    std::memcpy(&first, chunk.data(), sizeof first);
    for (std::size_t at = 0; at < chunk.size(); at += sizeof(Element)) {
        Element element;
        std::memcpy(&element, chunk.data() + at, sizeof element);
        bits = static_cast<Element>(bits | (element ^ first));
    }
    return bits;
}

std::uint64_t differing_bits(std::span<const std::byte> chunk, std::size_t element_bytes) {
    if (element_bytes == sizeof(std::uint64_t)) return differing_bits<std::uint64_t>(chunk);
    if (element_bytes == sizeof(std::uint32_t)) return differing_bits<std::uint32_t>(chunk);
    return element_bytes == 1 ? differing_bits<std::uint8_t>(chunk) : ~std::uint64_t{0};
}

template <std::size_t kElementBytes>
void gather_plane(const std::byte* from, std::size_t elements, std::byte* to) {
    for (std::size_t i = 0; i < elements; ++i) to[i] = from[i * kElementBytes];
}

}  // namespace

struct ChunkPacker::Stream {
    z_stream z = {};
    explicit Stream(int strategy) {
        const int made = deflateInit2(&z, kLevel, Z_DEFLATED, kWindowBits, kMemoryLevel, strategy);
        MELD_CHECK(made == Z_OK, "zlib says {}", made);
    }
    ~Stream() { deflateEnd(&z); }
    Stream(const Stream&) = delete;
    Stream& operator=(const Stream&) = delete;
};

bool ChunkPacker::Key::operator<(const Key& other) const {
    const auto order = [](const Key& key) { return std::tuple(key.all_alike, key.size, key.hash.low64, key.hash.high64); };
    return order(*this) < order(other);
}

ChunkPacker::ChunkPacker() = default;
ChunkPacker::~ChunkPacker() = default;

// Ends on a whole byte, so that other planes can follow. Returns how many bytes it takes.
std::size_t ChunkPacker::deflate(std::span<const std::byte> bytes, Way way, std::span<std::byte> to) {
    std::unique_ptr<Stream>& stream = way == Way::Codes ? codes_ : matches_;
    if (!stream) stream = std::make_unique<Stream>(way == Way::Codes ? Z_HUFFMAN_ONLY : Z_DEFAULT_STRATEGY);
    z_stream& z = stream->z;
    deflateReset(&z);
    z.next_in = bytes_of(bytes.data());
    z.avail_in = static_cast<uInt>(bytes.size());
    z.next_out = bytes_of(to.data());
    z.avail_out = static_cast<uInt>(to.size());
    const int done = ::deflate(&z, Z_SYNC_FLUSH);
    MELD_CHECK(done == Z_OK && z.avail_in == 0 && z.avail_out > 0, "zlib says {}", done);
    return to.size() - z.avail_out;
}

ChunkPacker::Way ChunkPacker::best_way(std::span<const std::byte> plane) {
    const std::size_t bytes = std::min(plane.size(), kSampleBytes);
    const std::span<const std::byte> sample = plane.subspan((plane.size() - bytes) / 2, bytes);
    const std::size_t codes = deflate(sample, Way::Codes, room_), matches = deflate(sample, Way::Deflate, room_);
    if (matches * kMatchesOf <= codes * (kMatchesOf - kMatchesSave)) return Way::Deflate;
    return codes * kCodesOf <= bytes * (kCodesOf - kCodesSave) ? Way::Codes : Way::AsItIs;
}

void ChunkPacker::pack(std::span<const std::byte> plane, Packed& to) {
    // zlib's bound is for streams that end; a block that is empty ends this one.
    room_.resize(std::max(plane.size(), kSampleBytes) * 2);
    const Way way = best_way(plane);
    if (way != Way::AsItIs) {
        to.bytes.assign(room_.begin(), room_.begin() + static_cast<std::ptrdiff_t>(deflate(plane, way, room_)));
    } else {
        to.bytes.reserve(plane.size() + (plane.size() / kMostStoredBytes + 1) * kBlockBytes);
        for (std::span<const std::byte> left = plane; !left.empty(); left = left.subspan(std::min(left.size(), kMostStoredBytes))) {
            const std::size_t size = std::min(left.size(), kMostStoredBytes), opposite = ~size;
            for (const std::size_t part : {std::size_t{0}, size, size >> 8, opposite, opposite >> 8})
                to.bytes.push_back(static_cast<std::byte>(part & 0xff));
            to.bytes.insert(to.bytes.end(), left.begin(), left.begin() + static_cast<std::ptrdiff_t>(size));
        }
    }
    to.checksum = adler32(adler32(0, nullptr, 0), bytes_of(plane.data()), static_cast<uInt>(plane.size()));
}

// Memory for what is known is limited, so that recordings in which every plane is another one do not keep them all.
const ChunkPacker::Packed& ChunkPacker::packed(const Key& key, std::span<const std::byte> plane) {
    if (const auto found = known_.find(key); found != known_.end()) return found->second;
    if (known_bytes_ > kMostKnownBytes) {
        known_.clear();
        known_bytes_ = 0;
    }
    Packed& made = known_[key];
    pack(plane, made);
    known_bytes_ += made.bytes.size() + kKnownBytes;
    return made;
}

std::vector<std::byte> ChunkPacker::pack(std::span<const std::byte> chunk, std::size_t element_bytes) {
    MELD_EXPECT(element_bytes <= kMostElementBytes && !chunk.empty() && chunk.size() % element_bytes == 0, "{} bytes, {} each",
                chunk.size(), element_bytes);
    const std::size_t elements = chunk.size() / element_bytes;
    const std::uint64_t differing = differing_bits(chunk, element_bytes);
    std::vector<std::byte> out(kHeader.begin(), kHeader.end());
    unsigned long checksum = adler32(0, nullptr, 0);
    plane_.resize(elements);
    const auto add = [&](const Packed& plane) {
        out.insert(out.end(), plane.bytes.begin(), plane.bytes.end());
        checksum = adler32_combine(checksum, plane.checksum, static_cast<z_off_t>(elements));
    };
    // Numbers in memory have their lowest byte first.
    for (std::size_t byte = 0; byte < element_bytes; ++byte) {
        const std::byte* const from = chunk.data() + byte;
        if ((differing >> (8 * byte) & 0xff) == 0) {
            const Key key = {.hash = {.low64 = std::to_integer<std::uint64_t>(*from), .high64 = 0}, .size = elements, .all_alike = true};
            if (!known_.contains(key)) std::ranges::fill(plane_, *from);
            add(packed(key, plane_));
            continue;
        }
        if (element_bytes == sizeof(std::uint64_t))
            gather_plane<sizeof(std::uint64_t)>(from, elements, plane_.data());
        else if (element_bytes == sizeof(std::uint32_t))
            gather_plane<sizeof(std::uint32_t)>(from, elements, plane_.data());
        else
            for (std::size_t i = 0; i < elements; ++i) plane_[i] = from[i * element_bytes];
        add(packed({.hash = XXH3_128bits(plane_.data(), elements), .size = elements, .all_alike = false}, plane_));
    }
    out.insert(out.end(), kEnd.begin(), kEnd.end());
    for (const int shift : {24, 16, 8, 0}) out.push_back(static_cast<std::byte>(checksum >> shift & 0xff));
    if (out.size() >= chunk.size()) out.clear();
    return out;
}

}  // namespace meld::record
