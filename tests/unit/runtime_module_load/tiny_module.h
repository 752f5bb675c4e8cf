// The bytes of the smallest file that has a module note: an ELF header, a note, a name table and three section headers.
#pragma once

#include <elf.h>
#include <unistd.h>

#include <cstring>
#include <string>

#include "runtime/module/abi/module_note.h"

namespace meld {

struct TinyModule {
    std::uint32_t abi_version = 1;
    std::uint64_t schema_hash = 0;
    std::string target = host_target();
};

template <class T>
void append_bytes(std::string& bytes, const T& value) {
    bytes.append(reinterpret_cast<const char*>(&value), sizeof value);
}

inline std::string note_section(const TinyModule& module) {
    std::string bytes;
    append_bytes(bytes, Elf64_Nhdr{.n_namesz = 9, .n_descsz = sizeof(ModuleNoteBytes), .n_type = kModuleNoteType});
    bytes += std::string(kModuleNoteOwner) + std::string(4, '\0');
    ModuleNoteBytes content = {};
    std::memcpy(content.magic, kModuleNoteMagic.data(), sizeof content.magic);
    content.abi_version = module.abi_version;
    content.size_bytes = sizeof content;
    content.schema_hash = module.schema_hash;
    std::memcpy(content.target, module.target.data(), module.target.size());
    append_bytes(bytes, content);
    return bytes;
}

inline std::string tiny_module(const TinyModule& module) {
    const std::string note = note_section(module);
    const std::string names = std::string(1, '\0') + std::string(kModuleNoteSection) + '\0';
    const std::size_t names_start = sizeof(Elf64_Ehdr) + note.size();
    Elf64_Ehdr header = {};
    std::memcpy(header.e_ident, ELFMAG, SELFMAG);
    header.e_ident[EI_CLASS] = ELFCLASS64;
    header.e_ident[EI_DATA] = ELFDATA2LSB;
    header.e_ident[EI_VERSION] = EV_CURRENT;
    header.e_type = ET_DYN;
#if defined(__x86_64__)
    header.e_machine = EM_X86_64;
#else
    header.e_machine = EM_AARCH64;
#endif
    header.e_version = EV_CURRENT;
    header.e_ehsize = sizeof(Elf64_Ehdr);
    header.e_shentsize = sizeof(Elf64_Shdr);
    header.e_shnum = 3;
    header.e_shstrndx = 2;
    header.e_shoff = names_start + names.size();
    const Elf64_Shdr note_header = {.sh_name = 1,
                                    .sh_type = SHT_NOTE,
                                    .sh_flags = SHF_ALLOC,
                                    .sh_addr = 0,
                                    .sh_offset = sizeof(Elf64_Ehdr),
                                    .sh_size = note.size(),
                                    .sh_link = 0,
                                    .sh_info = 0,
                                    .sh_addralign = 8,
                                    .sh_entsize = 0};
    const Elf64_Shdr names_header = {.sh_name = 0,
                                     .sh_type = SHT_STRTAB,
                                     .sh_flags = 0,
                                     .sh_addr = 0,
                                     .sh_offset = names_start,
                                     .sh_size = names.size(),
                                     .sh_link = 0,
                                     .sh_info = 0,
                                     .sh_addralign = 1,
                                     .sh_entsize = 0};
    std::string bytes;
    append_bytes(bytes, header);
    bytes += note + names;
    append_bytes(bytes, Elf64_Shdr{});
    append_bytes(bytes, note_header);
    append_bytes(bytes, names_header);
    static_cast<void>(seal_module(std::as_writable_bytes(std::span(bytes))));
    return bytes;
}

}  // namespace meld
