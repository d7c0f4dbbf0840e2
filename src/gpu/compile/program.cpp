#include "gpu/compile/program.hpp"

#include <algorithm>
#include <sstream>

namespace moraine::gpu {

std::string Program::text() const {
    std::string text;
    for (const std::string& macro : defines) text += "#define " + macro + "\n";
    for (const std::string& header : headers) text += "#include \"" + header + "\"\n";
    for (const std::string& own : texts) text += own;
    text += "\nusing namespace moraine;\nusing namespace moraine::gpu;\n\nextern \"C\" __device__ const unsigned ";
    text += std::string(facts_name) + "[] = {\n";
    for (const ProgramKernel& k : kernels)
        text += "    // " + k.expression + "\n    unsigned(" + k.threads + "), unsigned(" + k.bytes + "),\n";
    return text + "};\n";
}

Program merged(const std::vector<Program>& programs) {
    Program all;
    for (const Program& p : programs) {
        all.name += (all.name.empty() ? "" : "+") + p.name;
        const auto add = [](std::vector<std::string>& to, const std::vector<std::string>& from) {
            for (const std::string& one : from)
                if (std::find(to.begin(), to.end(), one) == to.end()) to.push_back(one);
        };
        add(all.headers, p.headers);
        add(all.texts, p.texts);
        add(all.defines, p.defines);
        all.kernels.insert(all.kernels.end(), p.kernels.begin(), p.kernels.end());
    }
    return all;
}

std::string packed(const CompiledProgram& program) {
    std::ostringstream body;
    body << program.names.size() << '\n';
    for (const std::string& name : program.names) body << name << '\n';
    body << program.image.size() << '\n' << program.image;
    return body.str();
}

std::optional<CompiledProgram> unpacked(const std::string& text) {
    std::istringstream in(text);
    std::size_t count = 0, size = 0;
    CompiledProgram program;
    if (!(in >> count) || count > 1000) return {};
    program.names.resize(count);
    for (std::string& name : program.names)
        if (!(in >> name)) return {};
    if (!(in >> size) || in.get() != '\n' || size > text.size()) return {};
    program.image.resize(size);
    if (!in.read(program.image.data(), static_cast<std::streamsize>(size))) return {};
    return program;
}

}  // namespace moraine::gpu
