#include "tests/bench/tool.h"

#include <cstdio>

#include "core/error.h"

namespace anyrate::bench {

int run_tool(CLI::App& app, int argc, char** argv, const std::function<Json()>& work) {
    try {
        app.parse(argc, argv);
        std::printf("%s\n", work().dump(1).c_str());
        return 0;
    } catch (const CLI::ParseError& error) {
        return app.exit(error) == 0 ? 0 : 2;
    } catch (const InputError& error) {
        std::fprintf(stderr, "%s: %s\n", argv[0], error.what());
        return 3;
    } catch (const std::exception& error) {
        std::fprintf(stderr, "%s: %s\n", argv[0], error.what());
        return 1;
    }
}

}  // namespace anyrate::bench
