// Plain values written as bytes and read back within bounds: for messages between processes, files, and migrating catoms.
//
// All processes of a run have the same program on the same kind of machine, and files name theirs, so values are copied unchanged.
#pragma once

#include <cstddef>
#include <cstdint>
#include <cstring>
#include <span>
#include <string>
#include <string_view>
#include <type_traits>
#include <utility>
#include <vector>

#include "runtime/base/assert.h"
#include "runtime/base/error.h"

namespace meld {

template <class T>
concept Plain = std::is_trivially_copyable_v<T> && !std::is_pointer_v<T>;

class ByteWriter {
  public:
    template <Plain T>
    void write(const T& value) {
        write_bytes(&value, sizeof value);
    }
    // The bytes alone: the reader knows how many there are.
    void write_bytes(const void* from, std::size_t size) {
        const auto* bytes = static_cast<const std::byte*>(from);
        if (size > 0) bytes_.insert(bytes_.end(), bytes, bytes + size);
    }
    // With their number before them.
    void write_block(std::span<const std::byte> block) {
        write_count(block.size());
        write_bytes(block.data(), block.size());
    }
    // A block whose bytes are written next: until end_block() gets what begin_block() returned.
    std::size_t begin_block() {
        write_count(0);
        return bytes_.size();
    }
    void end_block(std::size_t begun) {
        const std::size_t count = bytes_.size() - begun;
        MELD_CHECK(count <= 0xffffffff, "{} bytes in one block", count);
        const auto written = static_cast<std::uint32_t>(count);
        std::memcpy(bytes_.data() + begun - sizeof written, &written, sizeof written);
    }
    void write_string(std::string_view text) { write_block(std::as_bytes(std::span(text))); }
    void write_count(std::size_t count) {
        MELD_CHECK(count <= 0xffffffff, "{} items in one message", count);
        write(static_cast<std::uint32_t>(count));
    }

    void reserve(std::size_t size) { bytes_.reserve(size); }
    bool empty() const { return bytes_.empty(); }
    std::size_t size() const { return bytes_.size(); }
    std::span<const std::byte> view() const { return bytes_; }
    // The bytes written from this position on, to be changed in place.
    std::span<std::byte> written_from(std::size_t start) { return std::span(bytes_).subspan(start); }
    // Starts again empty, in the same memory.
    void clear() { bytes_.clear(); }
    // Hands over the bytes and starts again empty.
    std::vector<std::byte> take() { return std::exchange(bytes_, {}); }

  private:
    std::vector<std::byte> bytes_;
};

// If the bytes end too early, that is a bug where our own process wrote them, and an error of the user's world where they come from a file.
class ByteReader {
  public:
    enum class Origin { OwnProcess, Outside };
    // `what` names the bytes in messages ("a packet of exports"). Both must outlive the reader.
    ByteReader(std::span<const std::byte> bytes, const char* what, Origin origin = Origin::OwnProcess)
        : at_(bytes.data()), end_(bytes.data() + bytes.size()), size_(bytes.size()), what_(what), origin_(origin) {}

    // Whether everything has been read, or nothing more can be.
    bool done() const { return at_ == end_; }
    std::size_t left() const { return static_cast<std::size_t>(end_ - at_); }
    // The error of bytes from outside that ended too early, with the place. From then on every read gives zeros and done() holds.
    bool failed() const { return !error_.empty(); }
    Result<void> outcome() const;

    template <Plain T>
    T read() {
        T value{};
        if (holds(sizeof value)) [[likely]] {
            std::memcpy(&value, at_, sizeof value);
            at_ += sizeof value;
        }
        return value;
    }
    // Valid as long as the bytes; empty if they end too early.
    std::span<const std::byte> read_bytes(std::size_t size) {
        if (!holds(size)) [[unlikely]]
            return {};
        const std::byte* from = at_;
        at_ += size;
        return {from, size};
    }
    // As written by write_block and write_string.
    std::span<const std::byte> read_block() { return read_bytes(read<std::uint32_t>()); }
    std::string read_string() {
        const auto block = read_block();
        return {reinterpret_cast<const char*>(block.data()), block.size()};
    }
    // As written by write_count; each item takes at least this many bytes, so that a wrong count never allocates much memory.
    std::uint32_t read_count(std::size_t item_bytes) {
        const auto count = read<std::uint32_t>();
        return holds(count * item_bytes) ? count : 0;
    }

  private:
    bool holds(std::size_t size) {
        if (size <= left()) [[likely]]
            return true;
        end_too_early(size);
        return false;
    }
    void end_too_early(std::size_t size);

    const std::byte* at_;
    const std::byte* end_;
    std::size_t size_;
    const char* what_;
    Origin origin_;
    std::string error_;
};

}  // namespace meld
