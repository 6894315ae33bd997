#include "tools/grasp_cli/finger_option.h"

#include <string>
#include <vector>

namespace bullet_ccd::tools
{
namespace
{
void setFingers(grasp::ClosingOptions& closing, const std::vector<std::string>& words)
{
    closing.firstFingers.clear();
    const bool isWord = words.size() == 1;
    if (isWord && words[0] == grasp::toString(grasp::ClosingOrder::Together))
    {
        closing.order = grasp::ClosingOrder::Together;
        return;
    }
    closing.order = grasp::ClosingOrder::OneByOne;
    if (!isWord || words[0] != grasp::toString(grasp::ClosingOrder::OneByOne))
    {
        closing.firstFingers = words;
    }
}
}  // namespace

void addFingersOption(CLI::App& command, grasp::ClosingOptions& closing)
{
    command
        .add_option_function<std::vector<std::string>>(
            "--fingers",
            [&closing](const std::vector<std::string>& words) { setFingers(closing, words); },
            "together; or one-by-one: the next begins when the one before it\n"
            "has stopped; or names: these first, one by one, then the others")
        ->type_name("ORDER")
        ->delimiter(',')
        ->allow_extra_args(false)
        ->default_str(grasp::toString(closing.order))
        ->group("Closing");
}
}  // namespace bullet_ccd::tools
