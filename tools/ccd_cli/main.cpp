#include "tools/ccd_cli/commands/program.h"

int main(int argc, char** argv)
{
    return bullet_ccd::tools::runBulletCcd(argc, argv);
}
