#include "gpu/compile/program.hpp"

#include <algorithm>

namespace moraine::gpu {

std::string Program::text() const {
    std::string text;
    for (const std::string& header : headers) text += "#include \"" + header + "\"\n";
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
        for (const std::string& header : p.headers)
            if (std::find(all.headers.begin(), all.headers.end(), header) == all.headers.end())
                all.headers.push_back(header);
        all.kernels.insert(all.kernels.end(), p.kernels.begin(), p.kernels.end());
    }
    return all;
}

}  // namespace moraine::gpu
