// The steps from text to module, one line each.
#include "compiler/build/build.h"

#include <fmt/format.h>

#include <algorithm>
#include <deque>
#include <functional>
#include <span>

#include "compiler/build/content_hash.h"
#include "compiler/build/load_backend.h"
#include "compiler/build/pieces.h"
#include "runtime/module/abi/module_note.h"

namespace meld {
namespace {

// What linking adds to the objects.
constexpr std::size_t kSpaceOfModule_bytes = 1 << 17;

// Of the text and all that is done with it.
std::string content_hash(const std::function<void(ContentHash&)>& add_text, const std::string& name, const std::string& target,
                         const BuildOptions& options) {
    ContentHash hash;
    add_recipe(hash, target, options);
    add_text(hash);
    hash.add(name);
    hash.add(options.schema_hash);
    hash.add(options.abi_version);
    hash.add(options.linked.empty() ? "" : options.extern_header);
    hash.add(options.linked.size());
    for (const ExternSource& source : options.linked) {
        hash.add(source.path);
        hash.add(source.text);
    }
    return hash.digest();
}

// The C++ that puts the note of runtime/module/abi/module_note.h into the object; the checksum is filled in after linking.
std::string note_text(const std::string& target, const BuildOptions& options) {
    return fmt::format(R"(
#line 1 "module_note"
namespace {{
struct ClaymeldNote {{
    unsigned name_bytes, content_bytes, type;
    char name[12], magic[8];
    unsigned abi_version, size_bytes;
    unsigned long schema_hash, checksum;
    char target[16];
}};
}}
extern "C" {{
__attribute__((section("{}"), used, aligned(8))) static const ClaymeldNote claymeld_note = {{
    {}, {}, {}, "{}", {{{}}}, {}u, {}, {}ul, 0, "{}"}};
}}
)",
                       kModuleNoteSection, kModuleNoteOwner.size() + 1, sizeof(ModuleNoteBytes), kModuleNoteType, kModuleNoteOwner,
                       fmt::format("'{}'", fmt::join(kModuleNoteMagic, "', '")), options.abi_version, sizeof(ModuleNoteBytes),
                       options.schema_hash, target);
}

bool is_intact(const std::string& path, const BuildOptions& options) {
    const Result<std::string> file = read_module_file(path);
    if (!file) return false;
    const Result<ModuleNote> note = read_module_note(as_bytes(*file));
    return note && note->abi_version == options.abi_version && note->schema_hash == options.schema_hash;
}

// Every extern must be defined: a module with an undefined one could be loaded, and would end the process when it calls it.
Result<void> check_externs(const std::vector<ExternObject>& objects, const BuildOptions& options) {
    for (const std::string& name : options.externs) {
        bool found = false;
        for (const ExternObject& object : objects)
            found = found || std::find(object.symbols.begin(), object.symbols.end(), name) != object.symbols.end();
        if (found) continue;
        if (options.linked.empty())
            return fail(fmt::format("the extern `{}` is not linked", name),
                        fmt::format("Give the C file that defines {} with --link FILE.c", name), ExitCode::ProgramWrong);
        return fail(fmt::format("the extern `{}` is in none of the linked files", name),
                    fmt::format("Define {} in one of them; in C++ as extern \"C\"", name), ExitCode::ProgramWrong);
    }
    return {};
}

// Links the objects, fills in the checksum and puts the module where the cache expects it.
Result<void> link_and_publish(const Backend& backend, const std::vector<std::string>& objects, const std::string& module_path,
                              const BuildOptions& options) {
    std::deque<TemporaryFile> files;
    std::vector<std::string> paths;
    for (const std::string& object : objects) {
        const TemporaryFile& file = files.emplace_back(options.cache_dir, ".o");
        if (const Result<void> written = file.write(object); !written) return written;
        paths.push_back(file.path());
    }
    const TemporaryFile linked_file(options.cache_dir, ".linked");
    // lld ends the process if it cannot write. The module is about as large as its objects, and exists twice for a moment.
    std::size_t size_bytes = kSpaceOfModule_bytes;
    for (const std::string& object : objects) size_bytes += 2 * object.size();
    if (const Result<void> room = linked_file.check_space(size_bytes); !room) return room;
    if (const Result<void> linked = backend.link_module(paths, linked_file.path()); !linked) return linked;
    Result<std::string> module = read_module_file(linked_file.path());
    if (!module) return tl::unexpected(module.error());
    if (const Result<void> sealed = seal_module(std::as_writable_bytes(std::span(*module))); !sealed) return sealed;
    TemporaryFile sealed_file(options.cache_dir, ".sealed");
    if (const Result<void> written = sealed_file.write(*module); !written) return written;
    return sealed_file.publish(module_path);
}

using Objects = Result<std::vector<std::string>>;

// Takes the module from the cache, or links what `compile` makes.
Result<std::string> find_or_build(const std::string& hash, const std::string& target, const BuildOptions& options,
                                  const std::function<Objects(const Backend&)>& compile) {
    const std::string module_path = fmt::format("{}/{}{}", options.cache_dir, hash, kModuleExtension);
    // First of all, so that no other process removes it as one that nobody uses.
    touch(module_path);
    if (is_intact(module_path, options)) return module_path;
    const Result<const Backend*> backend = load_backend();
    if (!backend) return tl::unexpected(backend.error());
    Objects objects = compile(**backend);
    if (!objects) return tl::unexpected(objects.error());
    std::vector<ExternObject> linked;
    for (const ExternSource& source : options.linked) {
        Result<ExternObject> compiled =
            (*backend)->compile_extern(source, options.extern_header, {.optimisation = options.optimisation, .target_cpu = target});
        if (!compiled) return tl::unexpected(compiled.error());
        objects->push_back(std::move(compiled->object));
        linked.push_back(std::move(*compiled));
    }
    if (const Result<void> defined = check_externs(linked, options); !defined) return tl::unexpected(defined.error());
    if (const Result<void> published = link_and_publish(**backend, *objects, module_path, options); !published)
        return tl::unexpected(published.error());
    evict(options.cache_dir, module_path, options.limits);
    return module_path;
}

}  // namespace

Result<std::string> build_module(const std::string& cpp_text, const std::string& name, const BuildOptions& options) {
    if (const Result<void> made = make_cache_dir(options.cache_dir); !made) return tl::unexpected(made.error());
    const std::string target = host_target();
    const std::string hash = content_hash([&](ContentHash& all) { all.add(cpp_text); }, name, target, options);
    return find_or_build(hash, target, options, [&](const Backend& backend) {
        return backend.compile_object(cpp_text + note_text(target, options), name, options.headers,
                                      {.optimisation = options.optimisation, .target_cpu = target});
    });
}

Result<std::string> build_module(const TextInParts& text, const std::string& name, const BuildOptions& options) {
    if (const Result<void> made = make_cache_dir(options.cache_dir); !made) return tl::unexpected(made.error());
    const std::string target = host_target();
    const auto add_text = [&](ContentHash& all) {
        all.add(text.shared);
        all.add(text.parts.size());
        for (const TextPart& part : text.parts) {
            all.add(static_cast<std::uint64_t>(part.passes));
            all.add(part.text);
        }
    };
    return find_or_build(content_hash(add_text, name, target, options), target, options, [&](const Backend& backend) -> Objects {
        std::vector<Piece> pieces = divide_in_pieces(text);
        pieces.push_back({note_text(target, options), CodePasses::None});
        return compile_pieces(backend, text.shared, pieces, target, options);
    });
}

}  // namespace meld
