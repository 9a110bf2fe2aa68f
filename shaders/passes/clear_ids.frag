#version 330 core
// Zeros, as passes/clear.frag, for whole numbers.

layout(location = 0) out uint o_value;

void main()
{
    o_value = 0u;
}
