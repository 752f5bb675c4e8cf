// Finds the module note by walking the section headers of an ELF file, trusting none of its numbers.
#include "runtime/module/abi/module_note.h"

#include <elf.h>
#include <fmt/format.h>
#include <xxhash.h>

#include <algorithm>
#include <cstring>
#include <memory>
#include <optional>

#include "runtime/base/files/input_file.h"

namespace meld {
namespace {

#if defined(__x86_64__)
constexpr std::uint16_t kHostMachine = EM_X86_64;
#elif defined(__aarch64__)
constexpr std::uint16_t kHostMachine = EM_AARCH64;
#else
#error "Claymeld modules run on x86-64 and 64-bit ARM"
#endif

// The longest examples have modules of some 100 kB.
constexpr std::uint64_t kMaxModule_bytes = std::uint64_t{256} << 20;

using Bytes = std::span<const std::byte>;

tl::unexpected<Error> refuse(std::string problem) {
    return fail(std::move(problem), "Recompile it: meldc compile PROGRAM.meld", ExitCode::ModuleRefused);
}

// The bytes [offset, offset + size), or nothing when they are not all inside the file.
std::optional<Bytes> slice(Bytes file, std::uint64_t offset, std::uint64_t size) {
    if (offset > file.size() || size > file.size() - offset) return std::nullopt;
    return file.subspan(static_cast<std::size_t>(offset), static_cast<std::size_t>(size));
}

template <class T>
std::optional<T> read_at(Bytes file, std::uint64_t offset) {
    const std::optional<Bytes> bytes = slice(file, offset, sizeof(T));
    if (!bytes) return std::nullopt;
    T value;
    std::memcpy(&value, bytes->data(), sizeof(T));
    return value;
}

Result<Elf64_Ehdr> read_header(Bytes file) {
    const std::optional<Elf64_Ehdr> header = read_at<Elf64_Ehdr>(file, 0);
    if (!header || std::memcmp(header->e_ident, ELFMAG, SELFMAG) != 0) return refuse("it is not a shared object");
    if (header->e_ident[EI_CLASS] != ELFCLASS64 || header->e_ident[EI_DATA] != ELFDATA2LSB || header->e_type != ET_DYN)
        return refuse("it is not a 64-bit little-endian shared object");
    if (header->e_machine != kHostMachine) return refuse("it was built for another kind of processor");
    if (header->e_shentsize != sizeof(Elf64_Shdr) || !slice(file, header->e_shoff, std::uint64_t{header->e_shnum} * sizeof(Elf64_Shdr)))
        return refuse("it is damaged (its section table does not fit in the file)");
    return *header;
}

Elf64_Shdr section_at(Bytes file, const Elf64_Ehdr& header, std::size_t index) {
    return *read_at<Elf64_Shdr>(file, header.e_shoff + index * sizeof(Elf64_Shdr));
}

bool has_name(Bytes names, std::uint64_t offset, std::string_view wanted) {
    const std::optional<Bytes> text = slice(names, offset, wanted.size() + 1);
    return text && std::memcmp(text->data(), wanted.data(), wanted.size()) == 0 && text->back() == std::byte{0};
}

std::optional<Elf64_Shdr> find_section(Bytes file, const Elf64_Ehdr& header, std::string_view name) {
    if (header.e_shstrndx >= header.e_shnum) return std::nullopt;
    const Elf64_Shdr table = section_at(file, header, header.e_shstrndx);
    const std::optional<Bytes> names = slice(file, table.sh_offset, table.sh_size);
    if (!names) return std::nullopt;
    for (std::size_t i = 0; i < header.e_shnum; ++i) {
        const Elf64_Shdr section = section_at(file, header, i);
        if (has_name(*names, section.sh_name, name)) return section;
    }
    return std::nullopt;
}

// Where in the file the note's content starts.
Result<std::size_t> find_note(Bytes file) {
    const Result<Elf64_Ehdr> header = read_header(file);
    if (!header) return tl::unexpected(header.error());
    const std::optional<Elf64_Shdr> section = find_section(file, *header, kModuleNoteSection);
    if (!section || section->sh_type != SHT_NOTE) return refuse("it is not a Claymeld module (it has no .note.claymeld section)");
    const std::uint64_t owner_bytes = kModuleNoteOwner.size() + 1;
    const std::uint64_t content_start = sizeof(Elf64_Nhdr) + (owner_bytes + 3) / 4 * 4;
    const std::optional<Bytes> note = slice(file, section->sh_offset, section->sh_size);
    const std::optional<Elf64_Nhdr> frame = note ? read_at<Elf64_Nhdr>(*note, 0) : std::nullopt;
    if (!frame || note->size() < content_start + sizeof(ModuleNoteBytes) || frame->n_namesz != owner_bytes ||
        frame->n_descsz != sizeof(ModuleNoteBytes) || frame->n_type != kModuleNoteType ||
        !has_name(*note, sizeof(Elf64_Nhdr), kModuleNoteOwner))
        return refuse("it is damaged (its .note.claymeld section is malformed)");
    return static_cast<std::size_t>(section->sh_offset + content_start);
}

std::uint64_t checksum_without(Bytes file, std::size_t skipped) {
    const std::unique_ptr<XXH3_state_t, decltype(&XXH3_freeState)> state(XXH3_createState(), &XXH3_freeState);
    const std::size_t after = skipped + sizeof(ModuleNoteBytes::checksum);
    XXH3_64bits_reset(state.get());
    XXH3_64bits_update(state.get(), file.data(), skipped);
    XXH3_64bits_update(state.get(), file.data() + after, file.size() - after);
    return XXH3_64bits_digest(state.get());
}

}  // namespace

Result<ModuleNote> read_module_note(Bytes file) {
    const Result<std::size_t> start = find_note(file);
    if (!start) return tl::unexpected(start.error());
    const ModuleNoteBytes content = *read_at<ModuleNoteBytes>(file, *start);
    if (std::string_view(content.magic, sizeof content.magic) != kModuleNoteMagic || content.size_bytes != sizeof content)
        return refuse("it was built by another generation of Claymeld");
    if (content.checksum != checksum_without(file, *start + offsetof(ModuleNoteBytes, checksum)))
        return refuse("it is damaged (its checksum does not match)");
    const char* end = std::find(std::begin(content.target), std::end(content.target), '\0');
    return ModuleNote{.abi_version = content.abi_version,
                      .schema_hash = content.schema_hash,
                      .checksum = content.checksum,
                      .target = std::string(std::begin(content.target), end)};
}

Result<void> seal_module(std::span<std::byte> file) {
    const Result<std::size_t> start = find_note(file);
    if (!start) return tl::unexpected(start.error());
    const std::size_t place = *start + offsetof(ModuleNoteBytes, checksum);
    const std::uint64_t checksum = checksum_without(file, place);
    std::memcpy(file.data() + place, &checksum, sizeof checksum);
    return {};
}

Result<std::string> read_module_file(const std::string& path) { return read_input(path, kMaxModule_bytes); }

#if defined(__x86_64__)
bool host_runs(std::string_view target) {
    if (target == "x86-64-v3") return __builtin_cpu_supports("x86-64-v3") != 0;
    return target == "x86-64";
}
std::string host_target() { return host_runs("x86-64-v3") ? "x86-64-v3" : "x86-64"; }
#else
bool host_runs(std::string_view target) { return target == "generic"; }
std::string host_target() { return "generic"; }
#endif

}  // namespace meld
