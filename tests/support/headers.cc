// Carries the precompiled headers that all test programs share (tests/CMakeLists.txt).
int main() { return 0; }
