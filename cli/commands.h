// SPDX-License-Identifier: MIT
// The subcommands of `duet`: each is one file and one row of the table in
// main.c. argv[0] is the subcommand's name; each returns the exit status.
#ifndef CLI_COMMANDS_H
#define CLI_COMMANDS_H

int command_accuracy(int argc, char **argv);
int command_bench(int argc, char **argv);
int command_cluster(int argc, char **argv);
int command_devices(int argc, char **argv);
int command_lua(int argc, char **argv);
int command_picture(int argc, char **argv);
int command_profiles(int argc, char **argv);
int command_report(int argc, char **argv);
int command_explain(int argc, char **argv);
int command_run(int argc, char **argv);
int command_scenes(int argc, char **argv);
int command_source(int argc, char **argv);
int command_query(int argc, char **argv);
int command_tune(int argc, char **argv);
int command_verify(int argc, char **argv);

#endif
