#include "compile/law_file.hpp"

#include <dlfcn.h>
#include <sys/mman.h>
#include <unistd.h>

#include <deque>
#include <fstream>
#include <iterator>

#include "compile/source_bundle.hpp"
#include "compile/system_compiler.hpp"
#include "core/data/error.hpp"
#include "core/data/hash.hpp"
#include "core/material/laws.hpp"

namespace moraine {

namespace {

constexpr std::size_t largest_file = 1 << 20;  // bytes

std::string read_file(const std::filesystem::path& file) {
    std::ifstream in(file, std::ios::binary);
    std::string text(largest_file + 1, '\0');
    in.read(text.data(), static_cast<std::streamsize>(text.size()));
    text.resize(static_cast<std::size_t>(in.gcount()));
    if (text.empty()) throw InputError("cannot be read (or is empty). Is the path right, from the scene's folder?");
    if (text.size() > largest_file) throw InputError("is no law (it is larger than 1 MiB). Another file?");
    return text;
}

/// What is compiled for the host; the compiler's errors name the user's file and lines.
std::string program_of(const std::string& text, const std::string& path) {
    return "#include \"core/particles/law_object.hpp\"\n#line 1 " + quoted_path(path) + "\n" + text +
           "\n#line 1 \"end of the law\"\n"
           "extern \"C\" __attribute__((visibility(\"default\"))) void moraine_law(moraine::LawInfo* info) {\n"
           "    *info = moraine::describe_object<moraine::Law>();\n}\n";
}

/// Loads a shared object out of memory, until the end: nothing of it is left on disk, and nobody can change it between
/// two looks. Its file stays open, for the loader tells objects apart by their names.
LawInfo info_of(const std::string& object) {
    const int file = memfd_create("law", MFD_CLOEXEC);
    const bool written = file >= 0 && write(file, object.data(), object.size()) == static_cast<ssize_t>(object.size());
    void* library =
        written ? dlopen(("/proc/self/fd/" + std::to_string(file)).c_str(), RTLD_NOW | RTLD_LOCAL) : nullptr;
    void* entry = library ? dlsym(library, "moraine_law") : nullptr;
    if (!entry) {
        const char* why = written ? dlerror() : nullptr;
        throw InputError(std::string("cannot be loaded (") + (why ? why : "no memory") +
                         "). Does another compiler (CXX) make it?");
    }
    LawInfo info{};
    reinterpret_cast<void (*)(LawInfo*)>(entry)(&info);
    return info;
}

/// What a law in a file points to, until the end.
const char* kept(std::string text) {
    static std::deque<std::string> all;
    return all.emplace_back(std::move(text)).c_str();
}

}  // namespace

std::string quoted_path(const std::string& path) {
    std::string quoted = "\"";
    for (const char c : path)
        if (c != '\n') quoted += (c == '"' || c == '\\' ? std::string("\\") : std::string()) + c;
    return quoted + '"';
}

std::string load_law(const std::filesystem::path& file, const std::string& path, const CodeRights& rights) {
    const std::string text = read_file(file);
    const std::string hash =
        hexadecimal(mix_bytes(text.size(), reinterpret_cast<const std::byte*>(text.data()), text.size()));
    const std::string name = file.filename().string() + ":" + hash;
    if (find_law(name)) return name;
    const SystemCompiler compiler;
    const SourceBundle& headers = law_sources();
    const std::string program = program_of(text, path);
    const std::string key = CompileCache::key(program, SystemCompiler::options(), compiler.identity(), headers.hash);
    LawInfo info = info_of(rights.cache.find_or_make(key, [&] {
        if (rights.tell) rights.tell("Compiling the law of " + path + " (once: it is kept)");
        return compiler.compile(program, headers);
    }));
    info.file.title = info.name, info.name = kept(name);
    info.file.path = kept(path), info.file.text = kept(text), info.file.type = kept("Law_" + hash);
    add_law(info);
    return name;
}

}  // namespace moraine
