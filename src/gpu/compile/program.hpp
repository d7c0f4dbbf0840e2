#pragma once
// A program of device kernels that is compiled when a scene first wants it: some kernels of one family, which share a
// front end.
//
// A kernel is an expression of C++ that names an instance of a template; what its launch must know (threads and dynamic
// shared memory of a thread block) is an expression, too, that the compiler evaluates for the device. So the text of a
// program follows from a scene (gpu/kernels/programs.hpp), and the text, with the sources that it includes, is the key
// of what is kept on disk (compile/compile_cache.hpp).

#include <optional>
#include <string>
#include <vector>

namespace moraine::gpu {

struct ProgramKernel {
    std::string expression;  ///< names the kernel
    std::string threads;     ///< of a thread block
    std::string bytes;       ///< of dynamic shared memory of a thread block
};

struct Program {
    std::string name;                  ///< for messages
    std::vector<std::string> headers;  ///< as #include names them
    std::vector<ProgramKernel> kernels;
    std::vector<std::string> texts = {};    ///< behind the headers: laws in files
    std::vector<std::string> defines = {};  ///< macros that the headers ask for

    /// What is compiled: macros, headers, texts and the table of facts.
    std::string text() const;
};

/// One program with the kernels of several, in order: the front end, most of a small program's time, runs once.
Program merged(const std::vector<Program>& programs);

/// Name of the table of facts: threads and bytes of each kernel, 32-bit, in order.
inline constexpr const char* facts_name = "moraine_kernel_facts";

/// What a compiler made of a program for one kind of device.
struct CompiledProgram {
    std::string image;               ///< cubin
    std::vector<std::string> names;  ///< of the kernels in it, in order
    std::string log;                 ///< the compiler's: registers and spills of each kernel
};

/// Names and image as one text, for disks, and back.
std::string packed(const CompiledProgram& program);
std::optional<CompiledProgram> unpacked(const std::string& text);

}  // namespace moraine::gpu
