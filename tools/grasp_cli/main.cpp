#include "tools/grasp_cli/commands/program.h"

int main(int argc, char** argv)
{
    return bullet_ccd::tools::runGrasp(argc, argv);
}
